"""The detector of c_family/starter/detector.c and detector.cpp in Python."""

import numpy as np

BLOCK, DARK_BY, MOST = 3, 2.0, 64
NARROWEST, PLUMPEST, SLIMMEST, FULLEST = 8.0, 2.0, 4.5, 0.5


class Detector:
    def __init__(self, config):
        pass

    def detect(self, image):
        dark, found = dark_blocks(image), []
        for row, column in np.argwhere(dark).tolist():
            if dark[row, column] and len(found) < MOST:
                found += enclosed(*taken(dark, column, row))
        return found


def dark_blocks(image):
    pixels = image if image.ndim == 2 else image[:, :, 1]
    rows, columns = (side // BLOCK for side in pixels.shape)
    pixels = pixels[: rows * BLOCK, : columns * BLOCK].astype(float)
    sums = pixels.reshape(rows, BLOCK, columns, BLOCK).sum(axis=(1, 3))
    mean = sums.sum() / sums.size
    return sums < mean - DARK_BY * np.sqrt((sums * sums).sum() / sums.size - mean * mean)


def taken(dark, column, row):
    rows, columns = dark.shape
    region = [(column, row)]
    dark[row, column] = False
    for x, y in region:
        for i, j in ((x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)):
            if 0 <= i < columns and 0 <= j < rows and dark[j, i]:
                dark[j, i] = False
                region.append((i, j))
    return np.array(region, float).T


def enclosed(x, y):
    count = len(x)
    mean_x, mean_y = x.sum() / count, y.sum() / count
    xx = (x * x).sum() / count - mean_x * mean_x
    xy = (x * y).sum() / count - mean_x * mean_y
    yy = (y * y).sum() / count - mean_y * mean_y
    half = (xx - yy) / 2.0
    u = np.array([half + np.sqrt(half * half + xy * xy), xy])
    if not u.any():
        u = np.array([0.0, 1.0])
    ux, uy = u / np.sqrt(u[0] * u[0] + u[1] * u[1])
    along, across = x * ux + y * uy, y * ux - x * uy
    left, right = along.min() - 0.5, along.max() + 0.5
    top, bottom = across.min() - 0.5, across.max() + 0.5
    length, width = right - left, bottom - top
    share = count / (length * width)
    if width * BLOCK < NARROWEST or not PLUMPEST * width <= length <= SLIMMEST * width:
        return []
    if share < FULLEST:
        return []
    corners = [
        [BLOCK * (p * ux - q * uy) + (BLOCK - 1) / 2, BLOCK * (p * uy + q * ux) + (BLOCK - 1) / 2]
        for p, q in ((left, top), (right, top), (right, bottom), (left, bottom))
    ]
    return [("box", corners, min(share, 1.0))]

"""Procedural seabed: rippled sand with pebbles and shells, as a tile that repeats seamlessly.

Only an integer hash and + - * / sqrt are used, so every processor gives the same bytes: no FFT, no
blur and no noise of a library. The tile that every run needs, that of SEABED_SEED, is also stored,
a file for each channel, because painting it takes half a second.
"""

import hashlib
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numba import njit
from numpy.typing import NDArray

SEABED_SEED = 7  # the same seabed in all runs, so that it is not part of a trial's luck
TILE = 1024  # [texel] a power of two: the ray-caster wraps with a mask
STRIDE = TILE + 32  # [texel] from a row to the next in memory
TEXEL_M = 0.005  # about one pixel of both benchmarks' cameras, so no mipmaps are needed
_TEXTURES = Path(__file__).with_name("textures")  # textures/LICENSE.md
STORED_TILES = {  # channel -> file of SEABED_SEED
    0: _TEXTURES / "sand-red.png",
    1: _TEXTURES / "sand-green.png",
    2: _TEXTURES / "sand-blue.png",
}
_STORED_SHA256 = {  # of the files
    0: "faf983719c6578268439e84176eac8600376f95a32112022cb3b9de4cec824a7",
    1: "9c48c4e7492ea2bd3adbf1733b676c661942fc2c9fb4dbf1d3c6ef691a69730a",
    2: "afa9c7c122ee0f1c49bb81a301e5d484c4223ce047dab9c2d7f0daffd2952e0e",
}
SAND_TINT = (1.20, 1.0, 0.74)  # E: red, green, blue of quartz sand relative to its grey


@njit(cache=True, nogil=True, error_model="numpy")
def hash01(i: int, j: int, seed: int) -> float:
    """Return a number in [0, 1) that depends only on the three integers."""
    h = np.uint32(i) * np.uint32(0x9E3779B1) ^ np.uint32(j) * np.uint32(0x85EBCA77)
    h = np.uint32(h ^ np.uint32(seed) * np.uint32(0xC2B2AE3D))
    h = np.uint32(h ^ (h >> np.uint32(15))) * np.uint32(0x2C1B3C6D)
    h = np.uint32(h)
    h = np.uint32(h ^ (h >> np.uint32(12))) * np.uint32(0x297A2D39)
    h = np.uint32(h)
    h = np.uint32(h ^ (h >> np.uint32(15)))
    return float(h) * (1.0 / 4294967296.0)


@njit(cache=True, nogil=True, error_model="numpy")
def value_noise(x: float, y: float, cells: int, seed: int) -> float:
    """Return value noise in [-1, 1] at x, y in [0, 1), on a periodic lattice of `cells`²."""
    u = x * cells
    v = y * cells
    i = int(u)
    j = int(v)
    a = u - i
    b = v - j
    a = a * a * (3.0 - 2.0 * a)
    b = b * b * (3.0 - 2.0 * b)
    i2 = (i + 1) % cells
    j2 = (j + 1) % cells
    low = hash01(i, j, seed) * (1.0 - a) + hash01(i2, j, seed) * a
    high = hash01(i, j2, seed) * (1.0 - a) + hash01(i2, j2, seed) * a
    return 2.0 * (low * (1.0 - b) + high * b) - 1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _ripple(x: float, y: float, seed: int) -> float:
    """Return a warped ridge pattern in [-1, 1]: sand ripples, 9 cm apart."""
    warp = value_noise(x, y, 6, seed) + 0.4 * value_noise(x, y, 24, seed + 1)
    phase = 46.0 * y + 19.0 * x + 1.3 * warp + 0.35 * value_noise(x, y, 96, seed + 2)
    t = phase - np.floor(phase)
    wave = 4.0 * abs(t - 0.5) - 1.0
    return float(wave * (1.5 - 0.5 * wave * wave))


@njit(cache=True, nogil=True, error_model="numpy")
def _sand(x: float, y: float, seed: int) -> float:
    """Return the albedo of bare sand."""
    broad = 0.6 * value_noise(x, y, 3, seed + 3) + 0.4 * value_noise(x, y, 9, seed + 4)
    grain = 0.0
    amplitude = 0.034
    cells = 28
    for octave in range(5):
        grain += amplitude * value_noise(x, y, cells, seed + 5 + octave)
        cells *= 2
        amplitude *= 0.84
    strength = 0.05 + 0.03 * value_noise(x, y, 5, seed + 11)
    return 0.48 + 0.06 * broad + strength * _ripple(x, y, seed + 12) + grain


@njit(cache=True, nogil=True, error_model="numpy")
def _stone(x: float, y: float, albedo: float, cells: int, seed: int) -> float:
    """Return the albedo after the stones of one size class; light falls from the upper left."""
    ci = int(x * cells)
    cj = int(y * cells)
    for dj in range(-1, 2):
        for di in range(-1, 2):
            i = (ci + di) % cells
            j = (cj + dj) % cells
            if hash01(i, j, seed) > 0.30:
                continue
            dx = x * cells - (ci + di + 0.25 + 0.5 * hash01(i, j, seed + 1))
            dy = y * cells - (cj + dj + 0.25 + 0.5 * hash01(i, j, seed + 2))
            skew = 1.2 * hash01(i, j, seed + 3) - 0.6
            radius = 0.12 + 0.30 * hash01(i, j, seed + 4) * hash01(i, j, seed + 5)
            rough = 1.0 + 0.22 * value_noise(x, y, cells * 5, seed + 8)
            ex = rough * (dx + skew * dy) / radius
            ey = rough * (dy * (1.0 + 0.7 * hash01(i, j, seed + 6))) / radius
            distance = np.sqrt(ex * ex + ey * ey)
            shadow = np.sqrt((ex - 0.45) ** 2 + (ey - 0.45) ** 2)
            if distance < 1.0:
                tone = 0.22 + 0.40 * hash01(i, j, seed + 7)
                grit = 0.16 * value_noise(x, y, 256, seed + 9)
                light = 1.05 - 0.30 * (ex + ey) - 0.22 * distance * distance + grit
                edge = min(1.0, (1.0 - distance) * radius * 5.0 * TILE / cells / 6.0)
                albedo += edge * (tone * light - albedo)
            elif shadow < 1.0:
                albedo *= 0.62 + 0.38 * shadow
    return albedo


@njit(cache=True, nogil=True, error_model="numpy")
def _paint(seed: int) -> NDArray[np.float64]:
    tile = np.empty((TILE, TILE))
    for j in range(TILE):
        for i in range(TILE):
            x = (i + 0.5) / TILE
            y = (j + 0.5) / TILE
            albedo = _sand(x, y, seed)
            albedo = _stone(x, y, albedo, 96, seed + 40)
            albedo = _stone(x, y, albedo, 41, seed + 60)
            albedo = _stone(x, y, albedo, 13, seed + 80)
            speck = hash01(i, j, seed + 100)
            albedo += 0.05 * (hash01(i, j, seed + 101) - 0.5)
            if speck > 0.9965:
                albedo += 0.22 * hash01(i, j, seed + 102)
            tile[j, i] = min(max(albedo, 0.04), 0.97)
    return tile


@njit(cache=True, nogil=True, error_model="numpy")
def _tinted(
    albedo: NDArray[np.float64], channel: int, tint: float, seed: int
) -> NDArray[np.float64]:
    """Return one colour channel: bright sand takes the tint, dark stone stays grey."""
    out = np.empty_like(albedo)
    for j in range(TILE):
        for i in range(TILE):
            hue = 0.10 * value_noise((i + 0.5) / TILE, (j + 0.5) / TILE, 12, seed + 120)
            share = min(1.0, max(0.0, (albedo[j, i] - 0.15) * 3.0))
            factor = 1.0 + (tint - 1.0) * share * (1.0 + (hue if channel == 0 else -hue))
            out[j, i] = min(albedo[j, i] * factor, 1.0)
    return out


def quantise(albedo: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the albedo in 255ths, rounded."""
    return (albedo * 255.0 + 0.5).astype(np.uint8)


def packed(texels: NDArray[np.uint8], *, wrap: bool) -> NDArray[np.uint16]:
    """Return (rows * columns,) uint16 with a texel and, in the high byte, the one below it.

    One 32-bit load of two neighbours then serves a whole bilinear sample.
    """
    below = np.roll(texels, -1, axis=0)
    if not wrap:
        below[-1] = texels[-1]
    high = below.astype(np.uint16) << np.uint16(8)
    return (texels.astype(np.uint16) | high).ravel()


def padded(texels: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Return the packed tile with rows of STRIDE texels, (TILE * STRIDE,).

    The last texel of a row is followed by the first one, its neighbour. With rows of 2 KB all
    texels of a column would map to few cache sets and evict each other: an image took twice as long
    when the vehicle headed along the rows.
    """
    tile = np.zeros((TILE, STRIDE), np.uint16)
    tile[:, :TILE] = texels.reshape(TILE, TILE)
    tile[:, TILE] = tile[:, 0]
    return tile.ravel()


@lru_cache(maxsize=2)
def _albedo(seed: int) -> NDArray[np.float64]:
    tile: NDArray[np.float64] = _paint(seed)
    return tile


def painted(seed: int, channel: int) -> NDArray[np.uint8]:
    """Paint the tile (TILE, TILE) of one channel (0 red, 1 green, 2 blue) in 255ths."""
    albedo = _albedo(seed)
    if channel != 1:
        albedo = _tinted(albedo, channel, SAND_TINT[channel], seed)
    return quantise(albedo)


def texels(seed: int, channel: int) -> NDArray[np.uint8]:
    """Return what `painted` returns, from the stored tile if it is that one."""
    stored = _stored(channel) if seed == SEABED_SEED else None
    return painted(seed, channel) if stored is None else stored


def _stored(channel: int) -> NDArray[np.uint8] | None:
    """Return the stored tile of a channel; None if the file is missing or damaged."""
    try:
        content = STORED_TILES[channel].read_bytes()
    except OSError:
        return None
    if hashlib.sha256(content).hexdigest() != _STORED_SHA256[channel]:
        return None
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_GRAYSCALE)
    return np.asarray(image, np.uint8)


@lru_cache(maxsize=6)
def seabed(seed: int, channel: int) -> NDArray[np.uint16]:
    """Return the packed tile of one channel, with rows of STRIDE texels."""
    return padded(packed(texels(seed, channel), wrap=True))

"""Returns a million detections."""


def attack(image):
    return [("box", CORNERS, 0.5)] * 1_000_000

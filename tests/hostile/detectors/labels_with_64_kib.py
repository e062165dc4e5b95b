"""A label of 64 KiB."""


def attack(image):
    return [("x" * 65_536, CORNERS, 0.5)]

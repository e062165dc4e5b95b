"""Keeps every image, so that memory grows."""

kept = []


def attack(image):
    kept.append(image.copy())
    kept.append(b"x" * (40 << 20))

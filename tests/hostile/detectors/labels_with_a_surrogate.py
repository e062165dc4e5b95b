"""A label that is no text: it cannot be written in UTF-8."""


def attack(image):
    return [("\ud800", CORNERS, 0.5)]

"""A confidence that is no number."""


def attack(image):
    return [("box", CORNERS, float("nan"))]

"""A confidence without a limit."""


def attack(image):
    return [("box", CORNERS, float("inf"))]

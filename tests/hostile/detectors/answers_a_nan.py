"""A corner that is no number."""


def attack(image):
    return [("box", [*CORNERS[:3], [float("nan"), 1.0]], 0.5)]

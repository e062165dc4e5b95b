"""A corner at infinity."""


def attack(image):
    return [("box", [*CORNERS[:3], [1.0, float("inf")]], 0.5)]

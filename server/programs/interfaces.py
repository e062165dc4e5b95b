"""What a program in Python has to define, for each role that a benchmark can ask for."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Role:
    """A class and the methods by which it is called: name -> its arguments after self."""

    maker: str
    required: dict[str, tuple[str, ...]]
    optional: dict[str, tuple[str, ...]]


ROLES = {
    "controller": Role(
        "Controller",
        {"__init__": ("config",), "step": ("observation",)},
        {"reset": ("level",)},
    ),
    "tracker": Role(
        "Tracker",
        {"__init__": ("config",), "start": ("image", "corners"), "update": ("image",)},
        {},
    ),
    "detector": Role("Detector", {"__init__": ("config",), "detect": ("image",)}, {}),
}

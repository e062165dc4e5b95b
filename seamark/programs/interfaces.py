"""The class that a Python program has to define, for each role a benchmark can ask for."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Interface:
    """A class and its methods: name -> arguments after self."""

    class_name: str
    required: dict[str, tuple[str, ...]]
    optional: dict[str, tuple[str, ...]]


INTERFACES = {
    "controller": Interface(
        "Controller",
        {"__init__": ("config",), "step": ("observation",)},
        {"reset": ("level",)},
    ),
    "tracker": Interface(
        "Tracker",
        {"__init__": ("config",), "start": ("image", "corners"), "update": ("image",)},
        {},
    ),
    "detector": Interface("Detector", {"__init__": ("config",), "detect": ("image",)}, {}),
}

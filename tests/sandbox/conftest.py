"""Boxes and programs for tests of the sandbox itself."""

import contextlib
import gc
import os

from seamark.sandbox.box import Box

LAYOUT = {
    "observation": [["t", 0], ["error", 3], ["target_visible", 0], ["thrust", 5]],
    "booleans": ["target_visible"],
    "command": ["surge", "sway", "heave", "yaw_rate"],
}
VALUES = [0.25, 1.0, 2.0, 3.0, 1.0, 0.1, 0.2, 0.3, 0.4, 0.5]
PROGRAM = """
class Controller:
    def __init__(self, config):
        {init}

    def step(self, observation):
        {step}
        return [0.0, 0.0, 0.0, 0.0]
"""


def program(*, init: str = "pass", step: str = "pass") -> bytes:
    return PROGRAM.format(init=init, step=step).encode()


def printed(box: Box, source: bytes) -> str:
    """Return what a program prints in one step."""
    box.load(source, "mine.py", {"kp": 0.5}, LAYOUT)
    box.reset({"index": 0})
    box.step(VALUES)
    return box.finish().output.decode()


def descriptors() -> set[tuple[str, str]]:
    """Return what this process has open; what other tests left may be closed at any time."""
    opened = set()
    for number in os.listdir("/proc/self/fd"):
        with contextlib.suppress(FileNotFoundError):  # that of the list itself
            opened.add((number, os.readlink(f"/proc/self/fd/{number}")))
    return opened


def count_of_descriptors() -> int:
    """Return how many this process has open, without garbage of tests before."""
    gc.collect()
    return len(descriptors())

"""Looks for what the simulator knows and a program must not."""

import gc
import sys
import types

HELD = ()
PACKAGES = {"sim", "sandbox", "worker", "server", "seamark"}


def frames(observation):
    """Looks through the callers for the truth."""
    frame = sys._getframe()
    while frame:
        if {"seed", "truth", "state"} & set(frame.f_locals):
            return frame
        frame = frame.f_back


def memory(observation):
    """Looks through all objects for the seed."""
    return [
        key
        for thing in gc.get_objects()
        if isinstance(thing, dict)
        for key in thing
        if isinstance(key, str)
        and key in {"current_world", "hidden_seed"}
        and not isinstance(thing[key], types.BuiltinMethodType)
    ]


def modules(observation):
    """Looks for the simulator in its process."""
    return [name for name in sys.modules if name.partition(".")[0] in PACKAGES]

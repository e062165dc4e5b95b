"""Python: the interpreter of this service, with its NumPy and SciPy."""

from seamark.sandbox.languages.language import Language, Runtime

SELF_TEST = """\
import numpy as np


class Controller:
    def __init__(self, config):
        self.gain = 0.5

    def step(self, observation):
        return [*(self.gain * np.asarray(observation.error)), 0.0]


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners

    def update(self, image):
        return self.corners + image[1, 0]
"""


def runtime() -> Runtime:
    """Return command, environment and files of the interpreter."""
    from seamark.sandbox.languages.python_host import python_runtime  # noqa: PLC0415  (looks at the host)

    return python_runtime()


PYTHON = Language(
    "python",
    "Python",
    (".py",),
    runtime,
    SELF_TEST,
    mains=("main.py",),
    roles=("controller", "tracker", "detector"),
)

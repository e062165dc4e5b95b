"""The layers of the network: convolutions of 3 x 3 pixels, as it is trained and as it is computed.

Each layer gets the output of the one before it. That of `ADDED`, doubled in size, is added to that
of `KEPT`, and the sum goes on. All but the last are rectified.
"""

from typing import NamedTuple

from seamark.sim.detectors.network.reading import OUTPUTS, VIEWS


class Convolution(NamedTuple):
    """Channels of a layer, and how many pixels its window moves for one of its output."""

    inputs: int
    outputs: int
    stride: int = 1


LAYERS = {
    "fine1": Convolution(VIEWS, 16),
    "fine2": Convolution(16, 32, stride=2),
    "middle1": Convolution(32, 48, stride=2),
    "middle2": Convolution(48, 48),
    "broad1": Convolution(48, 64, stride=2),
    "broad2": Convolution(64, 64),
    "broad3": Convolution(64, 64),
    "broad4": Convolution(64, 48),
    "joined": Convolution(48, 48),
    "output": Convolution(48, OUTPUTS),
}
KEPT, ADDED = "middle2", "broad4"
LAST = "output"

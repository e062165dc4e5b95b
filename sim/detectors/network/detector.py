"""`network`: the learned detector, computed without ONNX Runtime, which chooses its code by CPU."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from seamark.sim.detectors.interface import Detection, Image, grey, most_confident
from seamark.sim.detectors.network.convolution import Layer, add_doubled, convolve, layer_of, plane
from seamark.sim.detectors.network.layers import ADDED, KEPT, LAST, LAYERS
from seamark.sim.detectors.network.reading import CELLS, OUTPUTS, STRIDE, VIEWS, answers, views

WEIGHTS = Path(__file__).with_name("weights.npz")
HEIGHT_PX, WIDTH_PX = (STRIDE * cells for cells in CELLS)


class Network:
    """Finds objects with a convolutional network."""

    def __init__(self) -> None:
        height, width = HEIGHT_PX // 2, WIDTH_PX // 2
        self._views = plane(height, width, VIEWS)
        self._layers: dict[str, Layer] = {}
        with np.load(WEIGHTS) as stored:
            for name, (_, _, stride) in LAYERS.items():
                height, width = height // stride, width // stride
                weights, biases = stored[f"{name}.weights"], stored[f"{name}.biases"]
                self._layers[name] = layer_of(
                    weights, biases, (height, width), stride=stride, rectified=name != LAST
                )
                if name == ADDED:
                    height, width = 2 * height, 2 * width

    def detect(self, image: Image) -> list[Detection]:
        """Return what is in an image of 240 x 320 pixels."""
        found = answers(self.output(views(grey(image))))
        return most_confident([Detection(*each) for each in found])

    def output(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the output (OUTPUTS, 30, 40) for views (VIEWS, 120, 160)."""
        _, height, width = seen.shape
        framed = self._views.reshape(height + 2, width + 2, VIEWS)
        framed[1:-1, 1:-1] = seen.transpose(1, 2, 0)
        last = self._views
        for name, layer in self._layers.items():
            convolve(last, layer)
            last = layer.output
            if name == ADDED:
                kept = self._layers[KEPT]
                add_doubled(last, kept.width, kept.output)
                last = kept.output
        rows, columns = CELLS
        whole = last.reshape(rows + 2, columns + 2, -1)[1:-1, 1:-1, :OUTPUTS]
        return np.ascontiguousarray(whole.transpose(2, 0, 1))

"""A small network, computed in a fixed order: every processor gives the same bits."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Layer = tuple[NDArray[np.float64], NDArray[np.float64]]  # weights (inputs, outputs), biases


def forward(layers: list[Layer], features: list[float]) -> list[float]:
    """Return the output: layers of rectified linear units, the last one linear."""
    x = np.array(features)
    for number, (weights, biases) in enumerate(layers):
        # Sums so far have but one order. That of a matrix product depends on the processor.
        x = np.add.accumulate(weights * x[:, None])[-1] + biases
        if number < len(layers) - 1:
            x = np.maximum(x, 0.0)
    output: list[float] = x.tolist()
    return output


def load(path: Path) -> list[Layer]:
    """Return the layers that `save` wrote."""
    with np.load(path) as stored:
        arrays = [stored[name].astype(np.float64) for name in stored.files]
    return list(zip(arrays[::2], arrays[1::2], strict=True))


def save(layers: list[Layer], path: Path) -> None:
    """Write layers, whose numbers must be those of float32."""
    names = (f"{part}{number}" for number in range(len(layers)) for part in ("weights", "biases"))
    arrays = (array.astype(np.float32) for layer in layers for array in layer)
    named: dict[str, Any] = dict(zip(names, arrays, strict=True))
    np.savez(path, **named)

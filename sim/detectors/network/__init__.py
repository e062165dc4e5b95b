"""A detector that learned from images with labels: how it was trained, and how it is computed.

`examples/detector/train.py --keep` writes network.json and weights.npz, which are our own work and
have the licence of the simulator (Apache-2.0): no image, weight or label is from elsewhere. This
module is light: it tells what the leaderboard says of the entry.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from seamark.sim.detectors.declaration import DetectorDeclaration

NETWORK = DetectorDeclaration(
    label="Convolutional network that learned from images with labels",
    path="seamark.sim.detectors.network.detector:Network",
)
TRAINED: Mapping[str, Any] = json.loads(Path(__file__).with_name("network.json").read_text("utf-8"))


def notes() -> str:
    """Return how the network was trained: when, on what, with which seeds, at what cost."""
    images, training = TRAINED["images"], TRAINED["training"]
    return (
        f"A network that was trained on {TRAINED['trained']} with {images['images']} images of "
        f"`seamark dataset {images['benchmark']} --seed {images['seed']}`, whose bottoms are in no "
        f"trial. Training: seed {training['seed']}, {training['passes']} passes over the images, "
        f"{training['cpu_s']} s of processor time."
    )

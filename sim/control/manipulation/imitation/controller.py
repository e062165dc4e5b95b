"""The learned entry of recover-v1: a network that imitates the scripted one, by demonstrations."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from seamark.sim.control.manipulation.imitation import POLICY
from seamark.sim.control.manipulation.imitation.features import PHASES, Imitator
from seamark.sim.control.manipulation.imitation.layers import forward, load

WEIGHTS = Path(__file__).with_name("weights.npz")


class Imitation(Imitator):
    """Does what the network says that is kept here: of a Girona 500 with `arm-5e-like`."""

    label = "Imitation: learned from the scripted entry"

    def __init__(self, config: Mapping[str, Any]) -> None:
        layers = load(WEIGHTS)

        def network(features: list[float]) -> tuple[list[float], list[float], list[float]]:
            output = forward(layers, features)
            return output[: -PHASES - 1], output[-PHASES - 1 : -PHASES], output[-PHASES:]

        super().__init__(config, POLICY, network)

"""A controller for currents-v2 that PPO has trained: it turns its bow into strong currents.

Beside it are policy.onnx, the network, and features.py, what it sees. `train.py` packs them.
"""

from pathlib import Path

import numpy as np
import onnxruntime
from features import STEPS, Features, row

ALONE = np.array([0])  # one vehicle, the first


class Controller:
    def __init__(self, config):
        network = str(Path(__file__).with_name("policy.onnx"))
        self.network = onnxruntime.InferenceSession(network)
        self.reset(None)

    def reset(self, level):
        self.features = Features(1)
        self.step_number = 0

    def step(self, observation):
        if self.step_number % STEPS == 0:
            seen = self.features.see(row(observation), ALONE)
            [actions] = self.network.run(None, {"features": seen})
            self.command = self.features.command(actions)[0].tolist()
        self.step_number += 1
        return self.command

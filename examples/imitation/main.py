"""A learned controller for recover-v1: a network that imitates a state machine, with its memory.

`train.py` packs it. Beside it in the archive are policy.onnx, the network, policy.json, what is
known of its training and of the arm, and features.py, what the network gets, with what that needs.
"""

import json
from pathlib import Path

import numpy as np
import onnxruntime
from features import Imitator


class Controller:
    def __init__(self, config):
        folder = Path(__file__).parent
        known = json.loads((folder / "policy.json").read_text())
        session = onnxruntime.InferenceSession(str(folder / "policy.onnx"))

        def network(features):
            given = np.asarray([features], np.float32)
            return [output[0].tolist() for output in session.run(None, {"features": given})]

        self.imitator = Imitator(config, known, network)

    def reset(self, level):
        self.imitator.reset(level)

    def step(self, observation):
        return self.imitator.step(observation)

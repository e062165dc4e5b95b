"""One array beyond the limit."""

import numpy as np


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return np.ones((1 << 14, 1 << 14))[0, :4]

"""Two processes answer."""

import os


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        os.fork()
        return [0.0, 0.0, 0.0, 0.0]

"""Leaves by sys.exit."""

import sys


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        sys.exit(0)
        return [0.0, 0.0, 0.0, 0.0]

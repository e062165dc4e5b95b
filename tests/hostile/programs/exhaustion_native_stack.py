"""Overflows the stack of native code."""

import sys


class Controller:
    def __init__(self, config):
        self.dive = lambda _: [0].sort(key=self.dive)

    def step(self, observation):
        sys.setrecursionlimit(10**8)
        self.dive(0)
        return [0.0, 0.0, 0.0, 0.0]

"""A list without end."""

import itertools


class Evil(list):
    def __iter__(self):
        return itertools.repeat(0.0)


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return Evil([0.0] * 4)

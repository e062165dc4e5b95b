"""Wants to hang at the end."""

import atexit


def spin():
    while True:
        pass


atexit.register(spin)


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

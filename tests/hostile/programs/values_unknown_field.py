"""Asks for the truth."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return observation.truth

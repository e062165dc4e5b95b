"""Answers with a huge number."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return [1e300, 0, 0, 0]

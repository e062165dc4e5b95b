"""Answers with NaN."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return [float("nan"), 0, 0, 0]

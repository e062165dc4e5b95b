"""Answers with an integer beyond float."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return [10**400, 0, 0, 0]

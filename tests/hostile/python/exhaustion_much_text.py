"""Prints more than is kept, less than is allowed."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        print("x" * 10_000)
        return [0.0, 0.0, 0.0, 0.0]

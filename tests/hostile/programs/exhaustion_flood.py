"""Prints without end."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        while True:
            print("water" * 100)
        return [0.0, 0.0, 0.0, 0.0]

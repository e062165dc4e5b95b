"""An exception whose text raises."""


class Evil(Exception):
    def __str__(self):
        raise Evil


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        raise Evil
        return [0.0, 0.0, 0.0, 0.0]

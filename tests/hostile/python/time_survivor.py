"""Leaves a daemon."""

import os
import time


class Controller:
    def __init__(self, config):
        if os.fork() == 0:
            os.setpgid(0, 0)
            if os.fork():
                os._exit(0)
            time.sleep(600)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

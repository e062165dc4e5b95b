"""Starts a shell by system()."""

import os


class Controller:
    def __init__(self, config):
        if os.system("id") == 0:
            print("GOT a shell")

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

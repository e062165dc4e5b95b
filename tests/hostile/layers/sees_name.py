"""Looks for the name of the host."""

import os


class Controller:
    def __init__(self, config):
        if os.uname().nodename != "sandbox":
            print("GOT", os.uname().nodename)

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]

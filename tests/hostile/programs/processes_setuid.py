"""Becomes root."""

import os


class Controller:
    def __init__(self, config):
        got = None
        try:
            os.setuid(0)
            got = os.getuid() == 0
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

"""Reads the worker's input."""

import sys


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = sys.stdin.read()
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

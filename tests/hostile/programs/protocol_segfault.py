"""Crashes the interpreter."""

import ctypes


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        ctypes.string_at(0)
        return [0.0, 0.0, 0.0, 0.0]

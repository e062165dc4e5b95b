"""Wants its own code called for the conversion."""

import os


class Evil:
    def __float__(self):
        os._exit(0)


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        return [Evil()] * 4

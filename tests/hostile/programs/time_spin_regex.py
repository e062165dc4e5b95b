"""A regular expression of exponential cost."""

import re


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        re.match(r"(a+)+$", "a" * 40 + "b")
        return [0.0, 0.0, 0.0, 0.0]

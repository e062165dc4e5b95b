"""Prints what could hurt a terminal, a page or a table."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        print("\x1b[2J\x00\r<script>alert(1)</script>{{7*7}}=cmd|calc")
        return [0.0, 0.0, 0.0, 0.0]

"""Burns CPU time in children."""

import os


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        for _ in range(3):
            if os.fork() == 0:
                while True:
                    pass
        os.wait()
        return [0.0, 0.0, 0.0, 0.0]

"""Sees MemoryError or is ended."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        heap = []
        while True:
            try:
                heap.append(b"x" * (1 << 24))
            except MemoryError:
                raise
        return [0.0, 0.0, 0.0, 0.0]

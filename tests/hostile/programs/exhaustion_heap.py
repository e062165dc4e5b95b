"""Takes memory without end."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        self.heap = []
        while True:
            self.heap.append(bytearray(1 << 20))
        return [0.0, 0.0, 0.0, 0.0]

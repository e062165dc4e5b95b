"""Takes memory when imported."""

heap = [b"x" * (1 << 20) for _ in range(4096)]


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

"""Makes the array writable."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        observation.error.setflags(write=True)
        return [0.0, 0.0, 0.0, 0.0]

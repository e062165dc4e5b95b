"""Fills shared memory."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        with open("/dev/shm/full", "wb") as file:
            while True:
                file.write(bytes(1 << 20))
        return [0.0, 0.0, 0.0, 0.0]

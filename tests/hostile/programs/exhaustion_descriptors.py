"""Opens files without end."""


class Controller:
    def __init__(self, config):
        self.count = 0

    def step(self, observation):
        self.files = []
        while True:
            self.files.append(open("/dev/null"))
        return [0.0, 0.0, 0.0, 0.0]

class Controller:
    def __init__(self, config):
        pass

    def step(self):
        return [0, 0, 0, 0]

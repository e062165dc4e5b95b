"""Takes for ever to start."""


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        while True:
            pass

    def update(self, image):
        return self.corners

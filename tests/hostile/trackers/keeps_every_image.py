"""Keeps every image, so that memory grows."""


class Tracker:
    def __init__(self, config):
        self.kept = []

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        self.kept.append(image.copy())
        self.kept.append(b"x" * (40 << 20))
        return self.corners

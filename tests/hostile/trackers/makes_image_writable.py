"""Switches the protection of the image off."""


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        image.setflags(write=True)
        image[0, 0] = 1
        print("GOT a writable image")
        return self.corners

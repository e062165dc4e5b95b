"""Answers with an object that pretends to be an array."""


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        class Pretender:
            shape = (4, 2)

            def __array__(self, *rest, **more):
                return self.no

        return Pretender()

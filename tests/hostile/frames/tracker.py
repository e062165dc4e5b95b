# Appended to each tracker in Python that is one function, `attack`: it makes it at each image.


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners

    def update(self, image):
        answer = attack(image)
        return self.corners if answer is None else answer

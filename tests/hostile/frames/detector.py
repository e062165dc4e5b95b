# Appended to each detector in Python that is one function, `attack`: it makes it at each image.

THIS = (3,)  # the number of the request for the first image: a header and a program came before
CORNERS = [[10.0, 20.0], [30.0, 20.0], [30.0, 40.0], [10.0, 40.0]]


def packed(label, *, corners=(10.0, 20.0, 30.0, 20.0, 30.0, 40.0, 10.0, 40.0), confidence=0.5):
    return struct.pack("<9dH", *corners, confidence, len(label)) + label


class Detector:
    def __init__(self, config):
        pass

    def detect(self, image):
        answer = attack(image)
        return [("box", CORNERS, 0.5)] if answer is None else answer

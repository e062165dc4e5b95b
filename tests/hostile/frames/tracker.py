# Appended to each tracker in Python that is one function, `attack`: it makes it at each image.

import os
import struct


def protocol():
    for number in range(3, 256):
        try:
            os.fstat(number)
        except OSError:
            continue
        return number


def send(kind, body, sequences=range(1, 64)):
    for sequence in sequences:
        os.write(protocol(), struct.pack("<cB2xI", kind, 1, sequence) + body)


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners

    def update(self, image):
        answer = attack(image)
        return self.corners if answer is None else answer

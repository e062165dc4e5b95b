"""Writes into the image by its address."""

import ctypes


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        ctypes.memset(image.ctypes.data, 7, 1)
        print("GOT the image")
        return self.corners

"""Reads memory that is not there."""

import ctypes


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        ctypes.string_at(0)
        return self.corners

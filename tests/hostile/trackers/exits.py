"""Ends its process in the middle."""

import os


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners
        pass

    def update(self, image):
        os._exit(0)

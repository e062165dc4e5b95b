"""Answers half the error; a tracker and a detector answer by the first pixel of the second row."""

import importlib
import sys

import numpy as np

PACKAGES = {"numpy": "NumPy", "scipy": "SciPy", "cv2": "OpenCV", "onnxruntime": "ONNX Runtime"}


def print_contents():
    print("interpreter", "Python", sys.version.split()[0], sep="\t")
    for name, label in PACKAGES.items():
        try:
            print("library", label, importlib.import_module(name).__version__, sep="\t")
        except ImportError:
            continue


class Controller:
    def __init__(self, config):
        self.gain = 0.5
        if config.get("contents"):
            print_contents()

    def step(self, observation):
        return [*(self.gain * np.asarray(observation.error)), 0.0]


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners

    def update(self, image):
        return self.corners + image[1, 0]


class Detector:
    def __init__(self, config):
        pass

    def detect(self, image):
        return [("row", image[1, 0] + np.arange(8.0).reshape(4, 2), 0.5)]

"""Programs in the further roles of a run; the hostile ones are in the tests of the worker."""

BENCHMARK = "mission-v1"
TRACKER = b"""
class Tracker:
    def __init__(self, config): ...
    def start(self, image, corners): ...
    def update(self, image):
        return None
"""
DETECTOR = b"""
class Detector:
    def __init__(self, config):
        print("looking for", config["lettering"])

    def detect(self, image):
        return []
"""
C_DETECTOR = b"""
#include "seamark.h"

int seamark_detect(const seamark_image *image, seamark_detection *found) {
    return 0;
}
"""

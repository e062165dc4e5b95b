"""A detector as a starting point: markers, and dark boxes with lettering.

OpenCV reads the markers. A box is a region much darker than the mean, with an outline that fills a
long rectangle and with bright letters in it.
"""

import cv2
import numpy as np

# Label -> dictionary of the markers, and modules across a marker with its black border
MARKERS = {"aruco": (cv2.aruco.DICT_4X4_50, 6), "apriltag": (cv2.aruco.DICT_APRILTAG_36h11, 8)}
DARK_BY = 1.5  # standard deviations below the mean
NARROWEST = 8  # minimum width of a box, in pixels
PROPORTIONS = 2.0, 4.5  # least and greatest length of a box, in widths
FULL = 0.7  # minimum share of the rectangle that the outline of a box fills
LETTERED = 0.05  # minimum share of bright pixels in a box
MOST = 64  # detections in an answer


class Detector:
    def __init__(self, config):
        # config: the configuration of the run, without the seed of the trial
        self.readers = {
            label: cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary))
            for label, (dictionary, _) in MARKERS.items()
        }

    def detect(self, image):
        # called with each image (height, width), 0 to 255, or (height, width, 3) in colour: red,
        # green, blue; returns a list of (label, corners, confidence), corners clockwise
        if image.ndim == 3:
            image = image[:, :, 1].copy()  # water absorbs red light first
        found = [one for label in MARKERS for one in self.markers(label, image)]
        return (found + boxes(image))[:MOST]

    def markers(self, label, image):
        """Return the markers of a dictionary, each with its white margin of one module."""
        corners, _, _ = self.readers[label].detectMarkers(image)
        modules = MARKERS[label][1]
        for marker in corners:
            centre = marker[0].mean(axis=0)
            yield label, centre + (marker[0] - centre) * (modules + 2) / modules, 1.0


def boxes(image):
    """Return the dark regions that may be boxes."""
    smooth = cv2.GaussianBlur(image, (5, 5), 0)
    mean, deviation = smooth.mean(), smooth.std()
    dark = (smooth < mean - DARK_BY * deviation).astype(np.uint8)
    outlines, _ = cv2.findContours(dark, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    found = []
    for outline in outlines:
        rectangle = cv2.minAreaRect(outline)
        width, length = sorted(rectangle[1])
        if width < NARROWEST or not PROPORTIONS[0] <= length / width <= PROPORTIONS[1]:
            continue
        share = cv2.contourArea(outline) / (width * length)
        inside = cv2.drawContours(np.zeros_like(image), [outline], 0, 1, cv2.FILLED)
        lettered = (image[inside == 1] > mean).mean()
        if share >= FULL and lettered >= LETTERED:
            found.append(("box", cv2.boxPoints(rectangle), min(share, 1.0)))
    return found

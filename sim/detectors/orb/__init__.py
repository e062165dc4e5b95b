"""`orb`: binary features of an image, matched with those of painted things."""

from seamark.sim.detectors.declaration import DetectorDeclaration
from seamark.sim.trackers.declaration import number_option

DETECTOR = DetectorDeclaration(
    label="Local features (ORB, OpenCV) and a similarity",
    path="seamark.sim.detectors.orb.detector:OrbDetector",
    options=(
        number_option(
            "orb_features",
            400,
            low=50,
            high=2000,
            title="Features",
            help="ORB: how many features are looked for in an image.",
        ),
    ),
)

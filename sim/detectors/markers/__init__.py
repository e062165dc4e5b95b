"""`markers`: fiducial markers, read by OpenCV's ArUco module."""

from seamark.sim.detectors.declaration import DetectorDeclaration
from seamark.sim.trackers.declaration import Option

DETECTOR = DetectorDeclaration(
    label="Fiducial markers alone (ArUco module of OpenCV)",
    path="seamark.sim.detectors.markers.detector:MarkerDetector",
    options=(
        Option(
            name="marker_stretch",
            default=True,
            title="Stretch the contrast",
            help="Markers: whether the image's greys are spread over the full range first.",
            advanced=True,
        ),
    ),
)

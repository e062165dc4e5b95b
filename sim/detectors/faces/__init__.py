"""`face` and `outline`: they find the lettered box, and the first reads its letters."""

from seamark.sim.detectors.declaration import DetectorDeclaration

FACE = DetectorDeclaration(
    label="Known face: finds boxes and reads their letters",
    path="seamark.sim.detectors.faces.detector:FaceDetector",
)
OUTLINE = DetectorDeclaration(
    label="Any box of its shape, without reading",
    path="seamark.sim.detectors.faces.detector:OutlineDetector",
)

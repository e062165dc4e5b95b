"""Marks on a leaderboard that recognise nothing: what chance alone reaches."""

from seamark.sim.detectors.declaration import DetectorDeclaration

NOTHING = DetectorDeclaration(
    label="No answer at all",
    path="seamark.sim.detectors.references.detectors:Nothing",
)
RANDOM = DetectorDeclaration(
    label="Random rectangles of the sizes that objects have",
    path="seamark.sim.detectors.references.detectors:Random",
)

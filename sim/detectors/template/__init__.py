"""`template`: things are recognised by correlation with painted ones."""

from seamark.sim.detectors.declaration import DetectorDeclaration
from seamark.sim.trackers.declaration import number_option

DETECTOR = DetectorDeclaration(
    label="Template matching (painted things of every kind)",
    path="seamark.sim.detectors.template.detector:TemplateDetector",
    options=(
        number_option(
            "template_places",
            25,
            low=1,
            high=100,
            title="Places",
            help="Template matching: how many places of each size are looked at closely.",
        ),
    ),
)

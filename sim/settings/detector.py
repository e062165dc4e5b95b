"""Settings of the detector, composed from what the detectors of the registry declare."""

from functools import partial

from seamark.sim.detectors import declaration, option_errors, option_names
from seamark.sim.registry import BOX_DETECTORS, DETECTORS
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.declared import declarations, labels, with_options
from seamark.sim.settings.setting import setting

detector_setting = partial(setting, group="Detector", role="solution")
_DECLARED = declarations(DETECTORS, declaration)


class ChosenDetector(Configuration):
    """A detector and its options; a subclass says from which ones it is chosen."""

    detector: str = detector_setting("", title="Detector", help="Looks at the camera image.")

    def detector_options(self) -> dict[str, object]:
        """Return the options of the chosen detector."""
        return {name: getattr(self, name) for name in option_names(self.detector)}

    def exact(self) -> bool:
        """Return whether every processor gives the same bits."""
        # A stored run may name a detector that no longer exists.
        known = self.detector in DETECTORS | BOX_DETECTORS
        return known and declaration(self.detector).exact and super().exact()

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for what the detector does not support."""
        errors = option_errors(self.detector, self.detector_options())
        return errors | super().cross_field_errors()


@with_options("detector", _DECLARED, detector_setting)
class DetectorSettings(ChosenDetector):
    """Which detector, its options, and which images it gets."""

    detector: str = detector_setting(
        "template",
        title="Detector",
        help="Recognises objects in the camera image.",
        choices=labels(_DECLARED),
    )
    colour: bool = detector_setting(
        False,
        title="Colour images",
        help="Whether it gets colour images (height, width, 3) in red, green, blue instead of grey "
        "ones.",
    )

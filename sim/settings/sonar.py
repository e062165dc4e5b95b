"""Settings of an imaging sonar, whose images a program is given.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.control.observation import SONAR
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.setting import setting
from seamark.sim.sonar.device import FARTHEST_M, Device

GROUP = "Imaging sonar"
NONE, FORWARD = "none", "forward"
sonar_setting = partial(setting, group=GROUP, role="scenario")
_WITH_SONAR = {"sonar": (FORWARD,)}


class SonarSettings(ExperimentSettings):
    """A vehicle that may carry an imaging sonar.

    The group came to benchmarks that had runs already, so it is only stored where there is one.
    """

    sonar: str = sonar_setting(
        NONE,
        title="Imaging sonar",
        help="Gives a controller the images of a sonar, ten times a second.",
        choices={NONE: "None", FORWARD: "Forward-looking"},
    )
    sonar_range_m: float = sonar_setting(
        30.0,
        title="Range",
        help="What the last row of the image shows.",
        unit="m",
        low=2,
        high=FARTHEST_M,
        tag="E",
        source="covers the seabed that the beams reach from 5 m above it",
        applies=_WITH_SONAR,
    )
    sonar_tilt_rad: float = sonar_setting(
        0.35,
        title="Tilt",
        help="How far below straight ahead the sonar looks.",
        unit="rad",
        low=-0.2,
        high=1.2,
        tag="E",
        source="20°: the seabed fills the image from 5 m above it",
        applies=_WITH_SONAR,
    )

    def sonar_device(self) -> Device | None:
        """Return the sonar, if there is one."""
        if self.sonar != FORWARD:  # a stored run may have another value
            return None
        return Device(range_m=self.sonar_range_m, tilt_rad=self.sonar_tilt_rad)

    def cameras_of_program(self) -> tuple[str, ...]:
        """Return the cameras whose images a controller is given, the sonar last."""
        sonar = () if self.sonar_device() is None else (SONAR,)
        return (*super().cameras_of_program(), *sonar)

    def unstored_groups(self) -> frozenset[str]:
        """Return the groups that are not stored: this one without a sonar."""
        own = frozenset({GROUP}) if self.sonar == NONE else frozenset()
        return super().unstored_groups() | own

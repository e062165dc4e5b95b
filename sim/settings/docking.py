"""Settings of a dock to enter: how a vehicle starts, and how it is told where the dock is.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial

from seamark.sim.settings.experiment import multiple
from seamark.sim.settings.search import FindingSettings
from seamark.sim.settings.setting import setting

GROUP, ANSWERS = "Dock", "Acoustic answers"
dock_setting = partial(setting, group=GROUP, role="scenario")
answer_setting = partial(setting, group=ANSWERS, role="scenario", advanced=True)


class DockSettings(FindingSettings):
    """What is entered, from where, and how well the vehicle is told where it is."""

    detector_period_s: float = dock_setting(
        0.5,
        title="Detector period",
        help="Time from one image in which the marker is looked for to the next.",
        unit="s",
        low=0.05,
        high=10,
        tag="E",
        source="a descent of 5 cm between them at 0.1 m/s",
        advanced=True,
    )
    approach_least_m: float = dock_setting(
        3.0,
        title="Nearest start",
        help="Least level distance from the dock at the start of each level.",
        unit="m",
        low=0,
        high=20,
        tag="E",
        source="the marker is out of view",
    )
    approach_most_m: float = dock_setting(
        7.0,
        title="Farthest start",
        help="Largest such distance; drawn evenly, in any direction.",
        unit="m",
        low=0,
        high=30,
        tag="E",
        source="where an acoustic return leg ends",
    )
    approach_rise_m: float = dock_setting(
        2.5,
        title="Spread of the start's height",
        help="Height of the start above the least one, the camera altitude; drawn evenly from 0 to "
        "this.",
        unit="m",
        low=0,
        high=5,
        tag="E",
        source="a vehicle that comes home above the dock",
    )
    into_current_rad: float = dock_setting(
        0.5,
        title="Heading of the dock",
        help="How far it may differ from the direction that the current comes from on average, to "
        "either side; drawn evenly.",
        unit="rad",
        low=0,
        high=3.1416,
        tag="E",
        source="a dock set up along the main current of its site",
    )
    turbidity_1_m: float = dock_setting(
        0.8,
        title="Turbidity",
        help="Attenuation that suspended matter adds, drawn evenly from 0 to this for each trial, "
        "alike for all colours.",
        unit="1/m",
        low=0,
        high=5,
        tag="E",
        source="up to turbid coastal water",
    )
    light_depths: float = dock_setting(
        6.0,
        title="Reach of the lamps",
        help="Optical depth, attenuation times distance, beyond which the dock's lamps are lost in "
        "the scattered light.",
        low=0,
        high=30,
        tag="E",
        source="lamps of the dock shine once through the water, daylight on a marker twice",
        advanced=True,
    )
    light_sigma_px: float = dock_setting(
        2.0,
        title="Noise of the lamps",
        help="Standard deviation of the middle of the lamps in the image.",
        unit="px",
        low=0,
        high=50,
        tag="E",
        source="blurred spots of some ten pixels",
        advanced=True,
    )
    fix_period_s: float = answer_setting(
        2.0,
        title="Time between answers",
        help="From one acoustic question of the vehicle to the next.",
        unit="s",
        low=0.5,
        high=60,
        tag="E",
        source="a transceiver of its own, for this alone",
    )
    fix_delay_s: float = answer_setting(
        0.3,
        title="Delay of answers",
        help="From the answer of the dock to when the vehicle has its direction, beside the way of "
        "the sound.",
        unit="s",
        low=0,
        high=10,
        tag="E",
        source="computed on board",
    )
    fix_least_m: float = answer_setting(
        3.0,
        title="Least range of answers",
        help="Nearer to the dock than this the vehicle gets none.",
        unit="m",
        low=0,
        high=20,
        tag="E",
        source="the transceiver hears its own ping and the echoes of the dock",
    )
    fix_range_sigma_m: float = answer_setting(
        0.1,
        title="Range noise",
        help="Standard deviation of the measured range.",
        unit="m",
        low=0,
        high=5,
        tag="E",
        source="the resolution at which small transceivers report it",
    )
    fix_angle_sigma_rad: float = answer_setting(
        0.0873,
        title="Angle noise",
        help="Standard deviation of the measured bearing and elevation.",
        unit="rad",
        low=0,
        high=0.5,
        tag="E",
        source="5°, a small transceiver beside its own thrusters; 0.5 m at 6 m",
    )
    fix_dropout: float = answer_setting(
        0.2,
        title="Missing answers",
        help="Share of the questions without an answer.",
        low=0,
        high=1,
        tag="E",
        source="noise of the thrusters, and echoes of the dock",
    )

    def has_dock(self) -> bool:
        """Return whether there is a dock to enter: always."""
        return True

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        if self.approach_most_m < self.approach_least_m:
            errors["approach_most_m"] = (
                "approach_most_m (Farthest start) must not be less than approach_least_m (Nearest "
                f"start) of {self.approach_least_m:g} m."
            )
        if not multiple(self.fix_period_s, self.control_period_s):
            errors["fix_period_s"] = (
                f"fix_period_s (Time between answers) must be a whole multiple of the control "
                f"period of {self.control_period_s:g} s, not {self.fix_period_s:g} s."
            )
        if self.contact_engine() == "pybullet":
            errors["contacts"] = (
                "contacts (Contact engine) must be the simulator's own: PyBullet has no dock."
            )
        return errors | super().cross_field_errors()

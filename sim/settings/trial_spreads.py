"""Settings of what is drawn once per trial: how far it spreads around the other settings.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math
from functools import partial
from typing import Any

from seamark.sim.settings.experiment import ExperimentSettings
from seamark.sim.settings.setting import group_of, setting

GROUP = "Drawn per trial"
# What would tell a program the conditions that it is not to know.
HIDDEN_GROUPS = frozenset({"Current", "Grid", "Faults", GROUP})
HIDDEN = frozenset({"levels", "score"})
spread_setting = partial(setting, group=GROUP, role="scenario", advanced=True)


class TrialSpreadSettings(ExperimentSettings):
    """Spreads of the conditions of a trial; 0 switches one off, without changing the others."""

    azimuth_spread_rad: float = spread_setting(
        3.14,
        title="Direction spread",
        help="Drawn evenly within plus or minus this around the direction of the current.",
        unit="rad",
        low=0,
        high=3.1416,
        tag="E",
        source="the full circle: nobody knows the current before a mission",
    )
    phase_spread_rad: float = spread_setting(
        3.14,
        title="Phase spread",
        help="Phases of the sinusoids of direction and speed, drawn uniformly within plus or minus "
        "this.",
        unit="rad",
        low=0,
        high=3.1416,
        tag="E",
        source="any phase",
    )
    swing_spread: float = spread_setting(
        0.5,
        title="Sinusoid spread",
        help="Amplitude of the direction and periods of direction and speed, each drawn uniformly "
        "within plus or minus this share of its setting.",
        low=0,
        high=0.9,
        tag="E",
        source="periods of the direction from 15 to 45 s",
    )
    gust_spread: float = spread_setting(
        0.5,
        title="Gust spread",
        help="Strength and time constant of the gusts, each drawn uniformly within plus or minus "
        "this share of its setting.",
        low=0,
        high=0.9,
        tag="E",
        source="gusts of 2.5 to 7.5 % of the mean speed",
    )
    change_turn_rad: float = spread_setting(
        0.8,
        title="Lasting turns",
        help="Each level has one lasting change of the current, and in half of the trials a second "
        "one; each turns it by up to this to either side.",
        unit="rad",
        low=0,
        high=3.1416,
        tag="E",
        source="comparable with the published amplitude of 0.7 rad",
    )
    change_speed_share: float = spread_setting(
        0.25,
        title="Lasting speed changes",
        help="The same changes add or take up to this share of the mean speed.",
        low=0,
        high=0.5,
        tag="E",
        source="five standard deviations of a gust",
    )
    start_offset_m: float = spread_setting(
        0.4,
        title="Start offset",
        help="Distance from the station at the start of each level, drawn uniformly within plus or "
        "minus this to the north and to the east.",
        unit="m",
        low=0,
        high=2,
        tag="E",
        source="the target is in view from every start",
    )
    start_heading_rad: float = spread_setting(
        0.35,
        title="Start heading",
        help="Heading at the start of each level, drawn uniformly within plus or minus this.",
        unit="rad",
        low=0,
        high=0.8,
        tag="E",
        source="20°: the lettering stays readable for every tracker",
    )
    dvl_bias_spread_m_s: float = spread_setting(
        0.01,
        title="DVL bias per trial",
        help="Constant error on each axis, drawn between half of this and this, of either sign.",
        unit="m/s",
        low=0,
        high=0.1,
        tag="E",
        source="5 mm/s makes dead reckoning drift by 0.3 m in a level",
    )
    ahrs_tilt_bias_rad: float = spread_setting(
        0.005,
        title="Roll and pitch bias",
        help="Constant error of each, drawn uniformly within plus or minus this.",
        unit="rad",
        low=0,
        high=0.1,
        tag="E",
        source="0.3°, typical of an AHRS",
    )
    ahrs_yaw_bias_rad: float = spread_setting(
        0.02,
        title="Heading bias",
        help="Constant error, drawn uniformly within plus or minus this.",
        unit="rad",
        low=0,
        high=0.2,
        tag="E",
        source="1.1°, typical of a compass",
    )
    camera_delay_steps: int = spread_setting(
        3,
        title="Camera latency",
        help="Control steps between an image and its position error, drawn from 0 to this.",
        unit="steps",
        low=0,
        high=20,
        tag="E",
        source="up to 0.15 s for exposure, transfer and tracking",
    )
    command_delay_steps: int = spread_setting(
        2,
        title="Command latency",
        help="Control steps between a command and the velocity controller, drawn from 0 to this.",
        unit="steps",
        low=0,
        high=20,
        tag="E",
        source="up to 0.1 s on the vehicle's network",
    )
    mass_spread: float = spread_setting(
        0.05,
        title="Mass spread",
        help="Mass and inertia of the body, drawn uniformly within plus or minus this share; "
        "weight and buoyancy stay.",
        low=0,
        high=0.5,
        tag="E",
        source="payload",
    )
    added_mass_spread: float = spread_setting(
        0.3,
        title="Added mass spread",
        help="Of each axis, drawn uniformly within plus or minus this share.",
        low=0,
        high=0.5,
        tag="E",
        source="uncertainty that the vehicles' data state",
    )
    drag_spread: float = spread_setting(
        0.2,
        title="Drag spread",
        help="Of each axis, drawn uniformly within plus or minus this share.",
        low=0,
        high=0.5,
        tag="E",
        source="published identifications of one vehicle differ by more",
    )
    thrust_spread: float = spread_setting(
        0.1,
        title="Thrust spread",
        help="Of each thruster, drawn uniformly within plus or minus this share.",
        low=0,
        high=0.5,
        tag="E",
        source="battery voltage, interaction with the hull",
    )
    weak_thruster_probability: float = spread_setting(
        0.25,
        title="Weak thruster",
        help="Share of the trials in which one thruster is weak.",
        low=0,
        high=1,
        tag="E",
        source="weed in a propeller on one mission in four",
    )
    weak_thruster_loss: float = spread_setting(
        0.5,
        title="Loss of the weak thruster",
        help="Share of its thrust that is missing, drawn between half of this and this.",
        low=0,
        high=1,
        tag="E",
        source="never dead: without its one sway thruster a Girona 500 cannot hold",
    )
    shuffle_levels: bool = spread_setting(
        True,
        title="Levels in random order",
        help="Whether the order of the levels is drawn, so that nobody knows the next current.",
    )

    def levels_in_order(self) -> bool:
        """Return whether the levels run as listed."""
        return not self.shuffle_levels

    def for_program(self) -> dict[str, Any]:
        """Return the settings that a program is given: nothing that tells the current."""
        fields = type(self).model_fields
        return {
            name: value
            for name, value in self.model_dump().items()
            if name not in HIDDEN and group_of(fields[name]) not in HIDDEN_GROUPS
        }

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        box = self.target_shape()
        metres = self.altitude_m / self.camera_focal_px
        half_view = 0.5 * metres * min(self.camera_width_px, self.camera_height_px)
        most = (half_view - 0.5 * math.hypot(box.length_m, box.width_m)) / math.sqrt(2.0)
        errors = super().cross_field_errors()
        if self.start_offset_m > max(most, 0.0) and not self.searches():
            errors["start_offset_m"] = (
                f"start_offset_m (Start offset) must be at most {max(most, 0.0):.2f} m with this "
                f"camera and altitude, not {self.start_offset_m:g} m: the target would be out of "
                f"view."
            )
        return errors

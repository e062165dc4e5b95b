"""The settings of visibility-v1: what degrades from level to level, and how the vehicle moves.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.tracking import METRICS
from seamark.sim.recording.telemetry import NAMES
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import ExperimentSettings, multiple
from seamark.sim.settings.setting import group_of, override, setting
from seamark.sim.settings.water_motion import WaterMotionSettings

sweep_setting = partial(setting, group="Sweep", role="scenario")
motion_setting = partial(setting, group="Motion", role="scenario")

INHERITED, MOVING = ExperimentSettings.model_fields, WaterMotionSettings.model_fields
_SCENE = "uwsimbenchmarks 988deda, visionBenchmarkScene.xml"
MAX_LEVELS = 200
DARKEST_STOPS = 5.5  # read noise of 1.2 grey is then amplified to 54 grey; 64 is the maximum
# Columns that stay 0 on a prescribed path.
STEERING = ("current_", "error_x", "error_y", "error_z", "ref_", "dvl_", "thrust_", "contact_n")
IMAGE_COLUMNS = ("error_x_px", "error_y_px")  # start like those, but come from the image
# Settings without effect on a prescribed path.
STEERING_GROUPS = {
    "Faults",
    "Sensors",
    "Position controller",
    "Velocity controller",
    "Station keeper",
}
STEERING_SETTINGS = {
    "vehicle",
    *("current_m_s", *WaterMotionSettings.model_fields),
    "physics_step_s",
    "contact",
    "seabed_relief_m",
    "seabed_flat_radius_m",
}


@dataclass(frozen=True, slots=True)
class Sweep:
    """What varies from level to level."""

    label: str
    level: Metric  # the quantity of a level's value
    is_depth: bool = False  # whether it sets the optical depth; the score is one then


SWEEPS = {
    "turbidity": Sweep(
        "Optical depth of the water", Metric("value", "Optical depth", "", "higher"), True
    ),
    "fog": Sweep(
        "Density of UWSim's fog (the paper's experiment)",
        Metric("value", "Fog density", "1/m", "higher"),
        True,
    ),
    "light": Sweep("Decreasing light", Metric("value", "Light reduction", "stops", "higher")),
    "camera_noise": Sweep("Camera noise", Metric("value", "Camera noise", "grey", "higher")),
}


class VisibilityConfiguration(ExperimentSettings, WaterMotionSettings):
    """Settings of visibility-v1. Seed, trials and program are not part of it."""

    vehicle: str = override(INHERITED["vehicle"], "girona500", group="Motion")
    level_duration_s: float = override(
        INHERITED["level_duration_s"],
        5.0,
        help="Simulated time before the tracker is initialised again and the next level begins.",
        source="uwsimbenchmarks: 5 s per level",
    )
    altitude_m: float = override(INHERITED["altitude_m"], 1.27, source=_SCENE)
    camera_width_px: int = override(INHERITED["camera_width_px"], 320, source=_SCENE)
    camera_height_px: int = override(INHERITED["camera_height_px"], 240, source=_SCENE)
    camera_focal_px: float = override(INHERITED["camera_focal_px"], 257.3, source=_SCENE)
    water_type: str = override(
        INHERITED["water_type"],
        "grey",
        tag="E",
        source="so that one number describes the turbidity",
    )
    water_attenuation_1_m: float = override(
        INHERITED["water_attenuation_1_m"],
        0.2,
        help="Attenuation, or density of the fog, of grey water whose levels vary something else.",
    )
    kp: float = override(INHERITED["kp"], 0.5, role="scenario")
    ki: float = override(INHERITED["ki"], 0.02, role="scenario")
    control_heave: bool = override(INHERITED["control_heave"], False, role="scenario")

    sweep: str = sweep_setting(
        "turbidity",
        title="Degradation",
        help="What varies from level to level; choosing it also sets its range.",
        choices={name: sweep.label for name, sweep in SWEEPS.items()},
    )
    sweep_from: float = sweep_setting(
        0.0, title="First level", help="Value at the first level.", low=0, high=100
    )
    sweep_to: float = sweep_setting(
        7.0,
        title="Last level",
        help="Value at the last level.",
        low=0,
        high=100,
        tag="E",
        source="nothing can be tracked there",
    )
    sweep_step: float = sweep_setting(
        0.25,
        title="Step",
        help="Difference between successive levels.",
        above=0,
        high=100,
        tag="E",
        source="fine enough to distinguish trackers",
    )
    score: str = custom_score_setting(METRICS, group="Experiment")
    mode: str = motion_setting(
        "fixed",
        title="Vehicle motion",
        help="On the prescribed path all trackers see the same images.",
        choices={
            "fixed": "Prescribed path",
            "free": "Closed loop: tracker and PI controller",
        },
    )
    path_swing_m: float = motion_setting(
        0.25,
        applies={"mode": ["fixed"]},
        title="Path amplitude",
        help="Prescribed path: amplitude in surge and sway; 0: stationary.",
        unit="m",
        low=0,
        high=1,
        tag="E",
        source="the target stays in the image",
    )
    path_turn_rad: float = motion_setting(
        0.05,
        applies={"mode": ["fixed"]},
        title="Path heading amplitude",
        help="Prescribed path: amplitude of the heading; roll and pitch have 0.6 times as much.",
        unit="rad",
        low=0,
        high=0.5,
        tag="E",
        source="a few degrees, like a vehicle in a current",
    )
    path_heave_share: float = motion_setting(
        0.2,
        applies={"mode": ["fixed"]},
        title="Path heave ratio",
        help="Prescribed path: heave amplitude relative to the path amplitude; 0: constant depth.",
        low=0,
        high=1,
        tag="E",
        source="vehicles hold depth better than position",
        advanced=True,
    )
    path_period_s: float = motion_setting(
        5.0,
        applies={"mode": ["fixed"]},
        title="Path period",
        help="Prescribed path: nominal period of the oscillation.",
        unit="s",
        low=1,
        high=120,
        tag="E",
        source="about that of a station-keeping vehicle",
    )
    current_m_s: float = motion_setting(
        0.15,
        title="Current",
        help="Closed loop: mean speed of the current.",
        unit="m/s",
        low=0,
        high=1,
        tag="E",
        source="every vehicle can hold station in it",
    )
    current_place: str = override(MOVING["current_place"], "none", group="Motion")
    current_record: str = override(MOVING["current_record"], "none", group="Motion")
    wave_height_m: float = override(MOVING["wave_height_m"], 0.0, group="Motion")
    wave_period_s: float = override(MOVING["wave_period_s"], 5.0, group="Motion")

    @classmethod
    def applies(cls, name: str) -> Mapping[str, Sequence[str]]:
        """Return also what has an effect only in closed loop."""
        steering = name in STEERING_SETTINGS or group_of(cls.model_fields[name]) in STEERING_GROUPS
        return {**super().applies(name), **({"mode": ("free",)} if steering else {})}

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        record = self.water_motion_errors(level_s=self.level_duration_s)
        own = record | self._sweep_errors() | self._path_errors()
        return own | super().cross_field_errors()

    def _sweep_errors(self) -> dict[str, str]:
        errors: dict[str, str] = {}
        span = self.sweep_to - self.sweep_from
        if span <= 0:
            errors["sweep_to"] = (
                f"sweep_to (Last level) must be greater than the first level, {self.sweep_from:g}, "
                f"not {self.sweep_to:g}."
            )
        elif not multiple(span, self.sweep_step) or span / self.sweep_step >= MAX_LEVELS:
            errors["sweep_step"] = (
                f"sweep_step (Step) must divide the {span:g} between first and last level into "
                f"whole steps, at most {MAX_LEVELS - 1}; {self.sweep_step:g} does not."
            )
        if self.sweep == "fog" and self.water_law != "uwsim":
            errors["water_law"] = (
                "water_law (Water model) must be uwsim when the levels set the density of the fog."
            )
        if self.sweep in ("turbidity", "fog") and self.water_type != "grey":
            errors["water_type"] = (
                "water_type (Water type) must be grey when the levels set the attenuation."
            )
        if self.sweep == "light" and self.sweep_to > DARKEST_STOPS:
            errors["sweep_to"] = (
                f"sweep_to (Last level) must be at most {DARKEST_STOPS:g} stops when the light "
                f"decreases, not {self.sweep_to:g}: no camera compensates for more."
            )
        if self.sweep == "camera_noise" and not 0.8 <= self.sweep_from <= self.sweep_to <= 64:
            errors["sweep_from"] = (
                "sweep_from (First level) and the last level must be from 0.8 to 64 grey for "
                "camera noise: below, rounding to whole grey levels decides which tracker fails."
            )
        return errors

    def _path_errors(self) -> dict[str, str]:
        """Return setting -> message for a path on which the target leaves the image."""
        room = 0.5 * min(self.camera_width_px, self.camera_height_px)
        per_m = self.camera_focal_px / self.altitude_m
        if self.mode != "fixed" or self.path_swing_m * per_m <= 0.7 * room:
            return {}
        return {
            "path_swing_m": (
                f"path_swing_m (Path amplitude) must be at most {0.7 * room / per_m:.2f} m at "
                f"this altitude, or the target leaves the image; not {self.path_swing_m:g} m."
            )
        }

    def level_values(self) -> tuple[float, ...]:
        """Return the value that is set at each level."""
        count = round((self.sweep_to - self.sweep_from) / self.sweep_step) + 1
        return tuple(round(self.sweep_from + i * self.sweep_step, 9) for i in range(count))

    def level_metric(self) -> Metric:
        """Return what a level's value is."""
        return self._swept().level

    def _swept(self) -> Sweep:
        """Return what the levels change; a stored run may name a sweep that no longer exists."""
        unknown = Sweep(self.sweep, Metric("value", self.sweep, "", "higher"))
        return SWEEPS.get(self.sweep, unknown)

    def headline(self) -> Metric | None:
        """Return the swept quantity if it is not the optical depth."""
        sweep = self._swept()
        if sweep.is_depth:
            return None
        return Metric("failure", "Failure level", sweep.level.unit, "higher")

    def unused_columns(self) -> frozenset[str]:
        """Return what a prescribed path leaves at 0; else what the vehicle does not use."""
        if self.mode == "free":
            return super().unused_columns()
        return frozenset(
            name for name in NAMES if name.startswith(STEERING) and name not in IMAGE_COLUMNS
        )

    def optical_depths(self) -> tuple[float, ...]:
        """Return the optical depth between camera and target at each level."""
        return tuple(self._optical_depth(value) for value in self.level_values())

    def _optical_depth(self, value: float) -> float:
        if self.sweep == "turbidity":
            return value
        density = value if self.sweep == "fog" else self.water_attenuation_1_m
        if self.water_law == "uwsim":
            return round((density * self.altitude_m) ** 2, 9)
        return round(density * self.altitude_m, 9)

    def score_values(self) -> tuple[float, ...]:
        """Return the value of each level in the unit of the score."""
        return self.optical_depths() if self._swept().is_depth else self.level_values()


# Values of other settings that come with a sweep.
SWEEP_PRESETS: dict[str, dict[str, object]] = {
    "fog": {  # S: the published experiment (visionBenchmarkScene.xml and its launch files)
        "water_law": "uwsim",
        "sweep_to": 2.0,
        "sweep_step": 0.05,
        "path_swing_m": 0.0,
        "path_turn_rad": 0.0,
    },
    "light": {
        "sweep_to": 5.5,
        "sweep_step": 0.25,
        "water_attenuation_1_m": 1.5,  # E: as below
    },
    "camera_noise": {
        "sweep_from": 1.0,
        "sweep_to": 41.0,
        "sweep_step": 2.0,
        "water_attenuation_1_m": 1.5,  # E: in clear water a good tracker tolerates any noise
    },
}

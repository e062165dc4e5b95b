"""The settings of visibility-v2: three axes of difficulty, and what is drawn for each trial.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import Any

from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.tracking_losses import METRICS
from seamark.sim.recording.telemetry import COLUMNS, WIDTH
from seamark.sim.registry import TRUTH
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.drawn_light import camera_noise_setting, light_setting
from seamark.sim.settings.experiment import multiple
from seamark.sim.settings.setting import setting
from seamark.sim.settings.targets import SEABED_TEXTURES, TARGET_TEXTURES
from seamark.sim.settings.tracker import RobustTrackerSettings

level_setting = partial(setting, group="Levels", role="scenario")
scene_setting = partial(setting, group="Scene", role="scenario")
motion_setting = partial(setting, group="Motion", role="scenario")

_SCENE = "uwsimbenchmarks 988deda, visionBenchmarkScene.xml"
MIXED = "mixed"
# Columns of the telemetry that this benchmark fills; the others stay 0.
_FILLED = (
    *("trial", "level", "t", "x", "y", "z", "roll", "pitch", "yaw", "u", "v", "w", "p", "q", "r"),
    *("target_x", "target_y", "tracked_x", "tracked_y", "tracker_ok", "tracker_error"),
    *(f"corner_{i}" for i in range(8)),
    *("error_x_px", "error_y_px", "distance_px", "distance", "step_us"),
)


@dataclass(frozen=True, slots=True)
class Axis:
    """What becomes more difficult from level to level."""

    name: str
    label: str
    unit: str
    level: str  # the name of one level, a format of its value


TURBIDITY = Axis("turbidity", "Optical depth", "", "τ {:g}")
MOTION = Axis("motion", "Image motion", "px per image", "{:g} px/image")
JUMP = Axis("jump", "Size of the jump", "px", "jump {:g} px")


@dataclass(frozen=True, slots=True)
class AxisLevel:
    """One level: its axis, and its value there."""

    axis: Axis
    value: float

    @property
    def name(self) -> str:
        """Return a short name."""
        return self.axis.level.format(self.value)


class VisibilityConfiguration(RobustTrackerSettings):
    """Settings of visibility-v2. Seed, trials and program are not part of it."""

    turbidity_levels: tuple[float, ...] = level_setting(
        tuple(0.5 * k for k in range(15)),
        title="Optical depths",
        help="Turbidity axis: optical depth of the water at each level, on the same path.",
        low=0,
        high=10,
        length=(2, 40),
        tag="E",
        source="at 7 a tenth of a grey level is left of the contrast",
    )
    motion_levels: tuple[float, ...] = level_setting(
        (4.0, 8.0, 12.0, 16.0, 20.0, 28.0, 36.0, 48.0),
        title="Image motions",
        help="Motion axis: mean path length of the target's corners from one image to the next.",
        unit="px",
        low=0.5,
        high=60,
        length=(2, 40),
        tag="E",
        source="from half the target's smaller half to half of its length",
    )
    jump_levels: tuple[float, ...] = level_setting(
        (4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0),
        title="Jumps",
        help="Jump axis: root mean square displacement of the target's corners between the image "
        "that the tracker is started with and the only one that follows.",
        unit="px",
        low=0.5,
        high=40,
        length=(2, 40),
        tag="E",
        source="from what every tracker follows to what none does",
    )
    level_duration_s: float = level_setting(
        2.0,
        title="Level duration",
        help="Simulated time before the tracker is initialised again and the next level begins.",
        unit="s",
        low=0.5,
        high=60,
        tag="E",
        source="40 images; a ranked run takes half a minute",
    )
    control_period_s: float = level_setting(
        0.05,
        title="Image period",
        help="Time from one image to the next.",
        unit="s",
        low=0.01,
        high=0.5,
        tag="S",
        source=f"{_SCENE}: 20 images per second",
        advanced=True,
    )
    score: str = custom_score_setting(METRICS, group="Levels")

    path_swing_m: float = motion_setting(
        0.25,
        title="Path amplitude",
        help="Mean amplitude in surge and sway; the trial's is drawn within 20 % of it.",
        unit="m",
        low=0.05,
        high=0.35,
        tag="E",
        source="the target stays in the image",
    )
    path_turn_rad: float = motion_setting(
        0.05,
        title="Path heading amplitude",
        help="Mean amplitude of the heading, drawn within 20 %; roll and pitch have 0.6 of it.",
        unit="rad",
        low=0,
        high=0.3,
        tag="E",
        source="a few degrees, like a vehicle in a current",
    )
    path_motion_px: float = motion_setting(
        3.0,
        title="Motion on the turbidity axis",
        help="Mean path length of the corners from one image to the next, drawn within 30 %.",
        unit="px",
        low=0.1,
        high=20,
        tag="E",
        source="0.3 m/s: a vehicle that holds station in a current",
    )
    motion_depth: float = motion_setting(
        1.0,
        title="Optical depth on the motion axis",
        help="Moderately clear water.",
        low=0,
        high=10,
        tag="E",
        source="a third of the contrast is left",
    )
    motion_exposure_s: float = motion_setting(
        0.01,
        title="Exposure time on the motion axis",
        help="How long the shutter is open: motion blur.",
        unit="s",
        low=0,
        high=0.01,
        tag="E",
        source="a bright day in shallow water",
    )
    start_error_px: float = motion_setting(
        0.3,
        title="Initial tracker error",
        help="Standard deviation of the corners with which the tracker is initialised.",
        unit="px",
        low=0,
        high=2.5,
        tag="E",
        source="what a careful person or detector achieves",
        advanced=True,
    )

    target_texture: str = scene_setting(
        MIXED,
        title="Target",
        help="What covers the box. Mixed: each trial has the next one, so that all count alike.",
        choices={MIXED: "Mixed", **TARGET_TEXTURES},
    )
    ground_texture: str = scene_setting(
        MIXED,
        title="Seabed",
        help="Mixed: drawn for each trial, never the target's.",
        choices={MIXED: "Mixed", **SEABED_TEXTURES},
    )
    altitude_m: float = scene_setting(
        1.27,
        title="Camera altitude",
        help="Height of the camera above the top of the target at the centre of the path.",
        unit="m",
        low=1.1,
        high=2,
        tag="S",
        source=_SCENE,
        advanced=True,
    )
    camera_noise_grey: float = camera_noise_setting(group="Scene")
    light_stops: float = light_setting(group="Scene", of="trial")

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        for name in ("turbidity_levels", "motion_levels", "jump_levels"):
            values = getattr(self, name)
            if any(b <= a for a, b in pairwise(values)):
                title = type(self).model_fields[name].title
                errors[name] = f"{name} ({title}) must increase from one to the next."
        if not multiple(self.level_duration_s, 2.0 * self.control_period_s):
            errors["level_duration_s"] = (
                f"level_duration_s (Level duration) must be an even number of image periods of "
                f"{self.control_period_s:g} s, not {self.level_duration_s:g} s."
            )
        if self.motion_exposure_s > self.control_period_s:
            errors["motion_exposure_s"] = (
                f"motion_exposure_s (Exposure time on the motion axis) must be at most the image "
                f"period of {self.control_period_s:g} s, not {self.motion_exposure_s:g} s."
            )
        return errors | super().cross_field_errors()

    def ranking_errors(self) -> dict[str, str]:
        """Return setting -> message for what a ranked run does not allow."""
        if self.tracker == TRUTH:
            return {"tracker": "tracker (Tracker) must not be the ground truth in a ranked run."}
        return {}

    def for_program(self) -> dict[str, Any]:
        """Return what a program may know: the camera, never water, path or order of the levels."""
        return {name: getattr(self, name) for name in ("control_period_s", "tracker")}

    def listed(self) -> tuple[AxisLevel, ...]:
        """Return the levels in their order: axis by axis, the most difficult first.

        All levels of the turbidity axis have the same path. What a tracker could remember of it
        from the levels before, it saw in worse water.
        """
        axes = (TURBIDITY, self.turbidity_levels), (MOTION, self.motion_levels)
        return tuple(
            AxisLevel(axis, value)
            for axis, values in (*axes, (JUMP, self.jump_levels))
            for value in reversed(values)
        )

    def levels_of(self, axis: Axis) -> tuple[int, ...]:
        """Return the indices of the levels of one axis, in their order."""
        return tuple(index for index, level in enumerate(self.listed()) if level.axis is axis)

    def images_per_start(self, level: int) -> int:
        """Return 2 for jumps: the tracker is started in one image and has one to converge."""
        return 2 if self.listed()[level].axis is JUMP else super().images_per_start(level)

    def level_metric(self) -> Metric:
        """Return what varies from level to level: one of three quantities, see `level_names`."""
        return Metric("value", "Level", "", "higher")

    def level_values(self) -> tuple[float, ...]:
        """Return the value of each level on its axis."""
        return tuple(level.value for level in self.listed())

    def level_names(self) -> tuple[str, ...]:
        """Return the name of each level."""
        return tuple(level.name for level in self.listed())

    def unused_columns(self) -> frozenset[str]:
        """Return what a prescribed path leaves at 0."""
        return frozenset(column.name for column in COLUMNS) - frozenset(_FILLED)

    def trial_duration_s(self) -> float:
        """Return the simulated duration of all levels together."""
        return len(self.listed()) * self.level_duration_s

    def telemetry_shape(self) -> tuple[int, int]:
        """Return how many rows a trial has, one per image, and how many columns."""
        return len(self.listed()) * self.control_steps_per_level, WIDTH

    @property
    def control_steps_per_level(self) -> int:
        """Images of one level."""
        return round(self.level_duration_s / self.control_period_s)

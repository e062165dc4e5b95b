"""The settings of patterns-v1: levels of optical depth, the camera's passage, and what is drawn.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from functools import partial
from itertools import pairwise
from typing import Any

from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.recognition import METRICS
from seamark.sim.recording.telemetry import COLUMNS, width_for
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.detector import DetectorSettings
from seamark.sim.settings.drawn_light import camera_noise_setting, light_setting
from seamark.sim.settings.experiment import multiple
from seamark.sim.settings.setting import setting

level_setting = partial(setting, group="Levels", role="scenario")
passage_setting = partial(setting, group="Passage", role="scenario")
scene_setting = partial(setting, group="Scene", role="scenario")

OPTICAL_DEPTH = Metric("optical_depth", "Optical depth", "", "higher")
# Columns of the telemetry that this benchmark fills beside those of detections; others stay 0.
_FILLED = (
    *("trial", "level", "t", "x", "y", "z", "roll", "pitch", "yaw", "u", "v", "w", "p", "q", "r"),
    "step_us",
)


class PatternsConfiguration(DetectorSettings):
    """Settings of patterns-v1. Seed, trials and program are not part of it."""

    optical_depths: tuple[float, ...] = level_setting(
        (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
        title="Optical depths",
        help="Optical depth of the water at each level, from the camera down to the bottom.",
        low=0,
        high=10,
        length=(1, 20),
        tag="E",
        source="at 6 a fifth of a grey level is left of the contrast",
    )
    level_duration_s: float = level_setting(
        12.0,
        title="Level duration",
        help="Simulated time before the next level begins, over another bottom.",
        unit="s",
        low=1,
        high=60,
        tag="E",
        source="24 images, in which the whole bottom passes by once",
    )
    control_period_s: float = level_setting(
        0.5,
        title="Image period",
        help="Time from one image to the next.",
        unit="s",
        low=0.05,
        high=5,
        tag="E",
        source="a survey's camera: neighbouring images overlap by six sevenths",
        advanced=True,
    )
    score: str = custom_score_setting(METRICS, group="Levels")

    speed_m_s: float = passage_setting(
        0.4,
        title="Speed",
        help="How fast the camera passes over the bottom.",
        unit="m/s",
        low=0,
        high=2,
        tag="E",
        source="a slow survey",
    )
    altitude_m: float = passage_setting(
        1.6,
        title="Camera altitude",
        help="Mean height of the camera above the bottom.",
        unit="m",
        low=1,
        high=4,
        tag="E",
        source="a pixel is 5 to 8 mm on the bottom",
    )
    altitude_spread_m: float = passage_setting(
        0.4,
        title="Altitude spread",
        help="A level's altitude is drawn from the mean, plus or minus this.",
        unit="m",
        low=0,
        high=0.5,
        tag="E",
        source="scale varies by two thirds",
        advanced=True,
    )
    tilt_rad: float = passage_setting(
        0.25,
        title="Tilt",
        help="Roll and pitch of a level are each drawn from 0, plus or minus this.",
        unit="rad",
        low=0,
        high=0.4,
        tag="E",
        source="markers are then seen at up to 50 degrees near the edge of the image",
        advanced=True,
    )
    burial: float = scene_setting(
        1.0,
        title="Burial",
        help="How deep things may lie in the sand: 1 hides up to half of one.",
        low=0,
        high=1,
        tag="E",
        source="what lies on the bottom for years",
    )
    snow_per_m3: float = scene_setting(
        40.0,
        title="Marine snow",
        help="Most particles of a level, drawn from 0 on.",
        unit="1/m³",
        low=0,
        high=200,
        tag="E",
        source="seen in every image, without hiding anything",
    )
    fish_per_min: float = scene_setting(
        4.0,
        title="Fish",
        help="Most fish of a level, drawn from 0 on. None is seen: a fish swims above the box, and "
        "this version has no box.",
        unit="1/min",
        low=0,
        high=60,
        tag="E",
        source="about one per level",
    )
    camera_noise_grey: float = camera_noise_setting(group="Scene")
    light_stops: float = light_setting(group="Scene", of="level")

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for the rules between several settings."""
        errors: dict[str, str] = {}
        if any(b <= a for a, b in pairwise(self.optical_depths)):
            errors["optical_depths"] = (
                "optical_depths (Optical depths) must increase from one to the next."
            )
        if not multiple(self.level_duration_s, self.control_period_s):
            errors["level_duration_s"] = (
                f"level_duration_s (Level duration) must be a multiple of the image period of "
                f"{self.control_period_s:g} s, not {self.level_duration_s:g} s."
            )
        return errors | super().cross_field_errors()

    def for_program(self) -> dict[str, Any]:
        """Return what a program may know: the camera, never water, path or bottom."""
        return {name: getattr(self, name) for name in ("control_period_s", "colour")}

    def level_metric(self) -> Metric:
        """Return what varies from level to level."""
        return OPTICAL_DEPTH

    def level_values(self) -> tuple[float, ...]:
        """Return the optical depth of each level."""
        return self.optical_depths

    def unused_columns(self) -> frozenset[str]:
        """Return what a prescribed path leaves at 0."""
        return frozenset(column.name for column in COLUMNS) - frozenset(_FILLED)

    def trial_duration_s(self) -> float:
        """Return the simulated duration of all levels together."""
        return len(self.optical_depths) * self.level_duration_s

    def telemetry_shape(self) -> tuple[int, int]:
        """Return how many rows a trial has, one per image, and how many columns."""
        rows = len(self.optical_depths) * self.control_steps_per_level
        return rows, width_for(0, detections=True)

    @property
    def control_steps_per_level(self) -> int:
        """Images of one level."""
        return round(self.level_duration_s / self.control_period_s)

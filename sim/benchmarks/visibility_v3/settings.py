"""The settings of visibility-v3: those of visibility-v2, and how the target moves by itself.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from seamark.sim.benchmarks.visibility_v2.settings import VisibilityConfiguration as Second
from seamark.sim.benchmarks.visibility_v2.settings import level_setting, motion_setting
from seamark.sim.metrics.tracking_answers import METRICS
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.setting import override

_INHERITED = Second.model_fields


class VisibilityConfiguration(Second):
    """Settings of visibility-v3. Seed, trials and program are not part of it."""

    turbidity_levels: tuple[float, ...] = override(
        _INHERITED["turbidity_levels"],
        (0.0, 1.0, 2.0, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 8.0, 9.0),
        source="at 9 nothing of the target is left for an observer that knows all but its place",
    )
    motion_levels: tuple[float, ...] = level_setting(
        (4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 44.0, 60.0),
        title="Image motions",
        help="Motion axis: mean path length of the target's corners from one image to the next.",
        unit="px",
        low=0.5,
        high=80,
        length=(2, 40),
        tag="E",
        source="to blur as long as the target's shorter side",
    )
    score: str = custom_score_setting(METRICS, group="Levels")

    path_swing_m: float = override(
        _INHERITED["path_swing_m"],
        0.16,
        help="Mean amplitude of the vehicle in surge and sway; the trial's is drawn within 20 %.",
    )
    path_motion_px: float = override(
        _INHERITED["path_motion_px"],
        3.0,
        source="0.2 m/s each: a vehicle that holds station, and a crawler",
    )
    target_swing_m: float = motion_setting(
        0.15,
        title="Target's path amplitude",
        help="How far the target moves over the bottom by itself, north and east: mean amplitude, "
        "drawn within 20 %.",
        unit="m",
        low=0,
        high=0.2,
        tag="E",
        source="as far as the vehicle; the target stays in the image",
    )
    target_turn_rad: float = motion_setting(
        0.12,
        title="Target's heading amplitude",
        help="Mean amplitude of the target's own heading, drawn within 20 %.",
        unit="rad",
        low=0,
        high=0.3,
        tag="E",
        source="seven degrees: a crawler that is steered",
    )
    motion_exposure_s: float = motion_setting(
        0.02,
        title="Exposure time on the motion axis",
        help="How long the shutter is open: motion blur.",
        unit="s",
        low=0,
        high=0.05,
        tag="E",
        source="a dull day, or ten metres down",
    )

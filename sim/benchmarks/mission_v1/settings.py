"""Settings of mission-v1: a whole mission, in levels of current and turbidity.

Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

from typing import Any

from seamark.sim.metrics.mission import METRICS
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.grid import GridSettings
from seamark.sim.settings.intervention import ARMED, InterventionSettings
from seamark.sim.settings.search import SearchSettings
from seamark.sim.settings.setting import override
from seamark.sim.settings.targets import RECOVERED_BOX, TargetShape
from seamark.sim.settings.trial_spreads import spread_setting

LETTERING = "SEAMARK"  # on the right box, as `camera.lettering` has it
_GRID = GridSettings.model_fields
_INHERITED = InterventionSettings.model_fields


class MissionConfiguration(InterventionSettings, SearchSettings):
    """Settings of mission-v1. Seed, trials and controller are not part of it."""

    levels: tuple[float, ...] = override(
        _INHERITED["levels"],
        (0.0, 0.25, 0.5),
        tag="E",
        source="beyond what the oracle holds; see docs/benchmarks.md",
    )
    loop1: str = override(_GRID["loop1"], "turbidity")
    loop1_values: tuple[float, ...] = override(
        _GRID["loop1_values"],
        (0.5, 2.0),
        tag="E",
        source="optical depths of 1 and 4 from the height of the search",
    )
    level_duration_s: float = override(
        ARMED["level_duration_s"],
        120.0,
        help="Simulated time of a mission; then everything returns to its start and the conditions "
        "change.",
        tag="E",
        source="twice what the oracle takes",
    )
    altitude_m: float = override(
        ARMED["altitude_m"],
        2.0,
        help="Height of the camera above the upper face of the box at the start of a level.",
        tag="E",
        source="3.4 by 2.5 m of the seabed are in view from there",
    )
    start_offset_m: float = spread_setting(
        4.5,
        title="Start distance",
        help="Largest distance from the box at the start of each level; drawn evenly from 60 % of "
        "it on, in any direction.",
        unit="m",
        low=0,
        high=10,
        tag="E",
        source="out of sight, and near enough for a mission of two minutes",
    )
    start_heading_rad: float = spread_setting(
        3.14,
        title="Start heading",
        help="Heading at the start of each level, drawn evenly within plus or minus this.",
        unit="rad",
        low=0,
        high=3.1416,
        tag="E",
        source="any heading",
    )
    turbidity_spread: float = override(
        _INHERITED["turbidity_spread"], 0.0, tag="E", source="a level sets the turbidity"
    )
    score: str = custom_score_setting(METRICS, group="Experiment")

    def target_shape(self) -> TargetShape:
        """Return the box."""
        return RECOVERED_BOX

    def for_program(self) -> dict[str, Any]:
        """Return the settings that a program is given, and what the right box is lettered with."""
        return super().for_program() | {"lettering": LETTERING}

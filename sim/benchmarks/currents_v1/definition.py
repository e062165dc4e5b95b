"""currents-v1: which position controller keeps station best while the current grows.

Five levels of 120 s each; at each the vehicle is put back and the tracker starts from the true
corners. Tags of the defaults: S sourced, D derived from sourced, E our estimate.
"""

import math
from functools import partial
from pkgutil import resolve_name

from seamark.sim.benchmarks.benchmark import Baseline, Benchmark, Chart, Table
from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.station_keeping import GROUP, HEAD, KEY_METRICS, METRICS, WHOLE, overall
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.registry import CONTROLLERS, VEHICLES
from seamark.sim.settings.custom_score import custom_score_setting
from seamark.sim.settings.experiment import ExperimentSettings, experiment_setting
from seamark.sim.settings.grid import SPEED, GridSettings
from seamark.sim.settings.setting import setting
from seamark.sim.vehicles import load, most_thrusters

current_setting = partial(setting, group="Current", role="scenario")


class CurrentsConfiguration(ExperimentSettings, GridSettings):
    """Settings of currents-v1. Seed, trials and controller are not part of it."""

    levels: tuple[float, ...] = experiment_setting(
        (0.0, 0.1, 0.2, 0.3, 0.4),
        title="Current levels",
        help="Mean speed of the current at each level, in rising order.",
        unit="m/s",
        low=0,
        high=1,
        length=(1, 12),
        tag="S",
        source="Pérez et al., the published experiment",
    )
    settle_s: float = experiment_setting(
        30.0,
        title="Settle window",
        help="Time at the start of each level that the settled metrics and the score leave out.",
        unit="s",
        low=0,
        high=599,
        tag="E",
        source="the first seconds after a start are the same for most controllers",
    )
    score: str = custom_score_setting(overall(), group="Experiment")

    current_law: str = current_setting(
        "relative",
        title="The current acts as",
        help="Relative velocity is physics; the body force is what the paper's simulator did.",
        choices={
            "relative": "Relative velocity of the water",
            "force": "Force on the body (the paper's simulator)",
        },
    )
    current_azimuth_rad: float = current_setting(
        0.0,
        title="Direction of the current",
        help="Where the water comes from, from the bow: 0 bow-on, 1.57 starboard (beam).",
        unit="rad",
        low=-math.pi,
        high=math.pi,
        tag="E",
        source="the published direction overpowers the real vehicle's one sway thruster",
    )
    current_swing_rad: float = current_setting(
        0.7,
        title="Swing of the direction",
        help="Amplitude of the sinusoid in the direction.",
        unit="rad",
        low=0,
        high=1.57,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_swing_period_s: float = current_setting(
        30.0,
        title="Period of the swing",
        help="Period of the sinusoid in the direction.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_wave_m_s: float = current_setting(
        0.005,
        title="Wave of the speed",
        help="Amplitude of the sinusoid in the speed; level 0 has none.",
        unit="m/s",
        low=0,
        high=0.5,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_wave_period_s: float = current_setting(
        4.0,
        title="Period of the wave",
        help="Period of the sinusoid in the speed.",
        unit="s",
        low=1,
        high=600,
        tag="S",
        source="uwsimbenchmarks 988deda, trackingBenchmarkDynamics.xml",
    )
    current_gust: float = current_setting(
        0.05,
        title="Gusts",
        help="Standard deviation of the random part, as a share of the level.",
        low=0,
        high=0.5,
        tag="E",
        source="the original draws 1 % white noise at every call, which depends on the call rate",
    )
    current_gust_time_s: float = current_setting(
        10.0,
        title="Gust time constant",
        help="How long a gust lasts (Ornstein-Uhlenbeck process).",
        unit="s",
        low=0.1,
        high=120,
        tag="E",
        source="some of them within a level",
    )
    current_shear: float = current_setting(
        0.0,
        title="Shear over the bottom",
        help="Exponent n: at height h the water has (h/h0)^n of its speed at the start's height "
        "h0. 1/7 is usual, 0 is the same at every depth.",
        low=0,
        high=1,
        tag="S",
        source="law and 1/7: DNV-RP-C205 (2010) 4.1.4; off in the published experiment",
        advanced=True,
    )
    current_force_share: float = current_setting(
        0.134,
        title="Share of the body force",
        help="Only as body force, 410 k v² N: the share k; 0.134 gives the paper's 18 px.",
        low=0,
        high=1,
        tag="D",
        source="fitted to one published number, 18 px at 0.4 m/s",
        advanced=True,
    )

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for the rules between several settings."""
        errors: dict[str, str] = {}
        if any(b <= a for a, b in zip(self.levels, self.levels[1:], strict=False)):
            errors["levels"] = "levels (Current levels) must rise from one to the next."
        if self.settle_s >= self.level_duration_s:
            errors["settle_s"] = (
                f"settle_s (Settle window) must be shorter than a level of "
                f"{self.level_duration_s:g} s, not {self.settle_s:g} s."
            )
        if self.current_shear and self.current_law == "force":
            errors["current_shear"] = (
                "current_shear (Shear over the bottom) must be 0 where the current acts as a body "
                "force: the water itself rests there."
            )
        return errors | super().cross_field_errors() or self.grid_errors()

    def level_metric(self) -> Metric:
        """Return what a level's value is."""
        return Metric("speed", "Current", "m/s", "higher")

    def level_values(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s]; in a grid, of each of its points."""
        return tuple(point[SPEED] for point in self.points())

    def base_levels(self) -> tuple[float, ...]:
        """Return the mean speeds [m/s] without a grid."""
        return self.levels


# What the published experiment has beside its vehicle's own defaults.
PAPER_SCENE = {
    "water_law": "uwsim",
    "water_type": "grey",
    "water_attenuation_1_m": 0.1,  # S: UWSim's default fog
    "range_from": "start",
    "level_out_tilt": False,
    "heading_hold": False,
    "depth_hold": False,
}


def _presets() -> dict[str, dict[str, object]]:
    """Return vehicle -> values that come with its choice."""
    own = {name: dict(load(name).defaults) for name in VEHICLES}
    own["girona500-uwsim"] |= PAPER_SCENE
    return {name: values for name, values in own.items() if values}


BENCHMARK = Benchmark(
    name="currents-v1",
    title="Position controllers in changing currents",
    summary=(
        "Keep station above a black box on the bottom while the current grows from 0 to 0.4 m/s in "
        "five levels of 120 s."
    ),
    participants="position controllers",
    role="controller",
    built_in={name: resolve_name(path).label for name, path in CONTROLLERS.items()},
    experiment="seamark.sim.benchmarks.currents_v1.experiment:EXPERIMENT",
    headline=Metric("score", "Score", "of 100", "higher"),
    score_bar_max=100.0,
    level_held_unit="m/s",
    charts=(
        Chart("Distance to the target", "px", ("distance_px",)),
        Chart("X error", "px", ("error_x_px",)),
        Chart("Y error", "px", ("error_y_px",)),
        Chart("Distance to the station", "m", ("distance",)),
        Chart("Error as the controller sees it", "m", ("error_x", "error_y", "error_z")),
        Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
        Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
        Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
        Chart("Tracker's error", "px", ("tracker_error",)),
        Chart("Thrust", "N", thrust_names(most_thrusters())),
        Chart("Contact force", "N", ("contact_n",)),
        Chart("Depth", "m", ("z",)),
        Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
    ),
    configuration=CurrentsConfiguration,
    groups=(
        "Experiment",
        "Position controller",
        "Tracker",
        "Grid",
        "Current",
        "Water and camera",
        "Station keeper",
        "Velocity controller",
        "Sensors",
        "Faults",
    ),
    tables=(
        Table("After the settle window of {settle_s:g} s", (*HEAD, *KEY_METRICS)),
        Table(
            "More metrics, after the settle window of {settle_s:g} s",
            tuple(metric for metric in METRICS if metric not in KEY_METRICS),
        ),
        Table("Whole levels", METRICS, prefix=WHOLE),
    ),
    key_metrics=KEY_METRICS[:1],
    metric_groups=(GROUP,),
    baselines={"p": Baseline("P, as it comes", "p"), "pi": Baseline("PI, as it comes", "pi")},
    presets={"vehicle": _presets()},
    quick_settings={"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0},
)

"""track-v1: which programs follow a route in the strongest current."""

from seamark.sim.benchmarks.benchmark import (
    Baseline,
    Benchmark,
    Chart,
    RankedProtocol,
    StartingPoint,
    Table,
)
from seamark.sim.benchmarks.track_v1.settings import TrackConfiguration
from seamark.sim.metrics import following
from seamark.sim.metrics.energy import ENERGY, POWER
from seamark.sim.metrics.metric import Metric
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.settings.route import FIXES
from seamark.sim.settings.route import GROUP as ROUTE
from seamark.sim.settings.sonar import FORWARD
from seamark.sim.settings.sonar import GROUP as SONAR
from seamark.sim.settings.trial_spreads import GROUP as SPREADS
from seamark.sim.settings.two_vehicles import MEASURED
from seamark.sim.vehicles import load, most_thrusters

CHARTS = (
    Chart("Cross-track error", "m", ("cross_track",)),
    Chart("Cross-track error to starboard and down", "m", ("cross_track_y", "cross_track_z")),
    Chart("Way along the route", "m", ("route_along",)),
    Chart("North: vehicle and acoustic fix", "m", ("x", "fix_x")),
    Chart("East: vehicle and acoustic fix", "m", ("y", "fix_y")),
    Chart("Depth", "m", ("z", "route_z")),
    Chart("Age of the acoustic fix", "s", ("fix_age",)),
    Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
    Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
    Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
    Chart("Thrust", "N", thrust_names(most_thrusters())),
    Chart("Contact force", "N", ("contact_n",)),
    Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
)
BUILT_IN = {
    "ilos": "Integral line of sight",
    "los": "Line of sight",
    "mpc": "MPC along the route, bow into the flow",
    "into-flow": "Integral line of sight, bow into the flow",
    "l1": "Line of sight, L1 adaptive velocity",
    "pi": "PI on the way to a point ahead",
    "p": "P on the way to a point ahead",
}
REFERENCE_BUILT_IN = {
    "mpc": "MPC along the route, bow into the flow",
    "into-flow": "Integral line of sight, bow into the flow",
    "pi": "PI on the way to a point ahead",
    "p": "P on the way to a point ahead",
    "nothing": "Nothing: zero velocity",
    "blind": "Blind: line of sight by DVL and compass, without fixes",
    "oracle": "Oracle: knows the truth",
}
BENCHMARK = Benchmark(
    name="track-v1",
    title="Follow a route",
    summary=(
        "Follow waypoints, helices and lemniscates by DVL, compass and sparse acoustic fixes, and "
        "a pipe by camera, in currents of up to 0.8 m/s, with two vehicles that are not quite as "
        "their data sheets say."
    ),
    question="Which programs follow a route most closely in the strongest current?",
    participants="programs",
    role="controller",
    follows_route=True,
    built_in=BUILT_IN,
    reference_built_in=REFERENCE_BUILT_IN,
    experiment="seamark.sim.benchmarks.track_v1.experiment:EXPERIMENT",
    headline=Metric("score", "Followed up to", "m/s", "higher"),
    scale=(0.013, 0.694),  # ./run performance route_headroom
    score_bar_max=0.8,
    level_held_unit="m/s",
    error_column="cross_track",
    charts=CHARTS,
    tables=(Table("Each level", (*following.METRICS, following.HELD)),),
    key_metrics=(following.QUALITY,),
    board_metrics=(following.CROSS_TRACK, following.PROGRESS, POWER, ENERGY),
    pareto=(following.CROSS_TRACK, POWER),
    metric_groups=(following.GROUP,),
    baselines={
        name: Baseline(label, name) for name, label in (REFERENCE_BUILT_IN | BUILT_IN).items()
    },
    configuration=TrackConfiguration,
    groups=(
        *(
            "Experiment",
            "Guidance",
            "Position controller",
            ROUTE,
            FIXES,
            "Current",
            "Grid",
            "Velocity controller",
        ),
        *("Sensors", SONAR, "Faults", SPREADS),
    ),
    presets={"vehicle": {name: load(name).defaults for name in MEASURED}},
    quick_settings={"levels": [0.2], "level_duration_s": 4.0},
    starting_points={
        "still-water": StartingPoint(
            "Still water", "One level without a current, to begin with.", {"levels": (0.0,)}
        ),
        "good-fixes": StartingPoint(
            "Exact fixes",
            "A position each half second, without noise or delay.",
            {
                "fix_period_s": 0.5,
                "fix_delay_s": 0.0,
                "fix_dropout": 0.0,
                "fix_range_sigma_m": 0.0,
                "fix_angle_sigma_rad": 0.0,
            },
        ),
        "sonar": StartingPoint(
            "With an imaging sonar",
            "Programs get its image ten times a second.",
            {"sonar": FORWARD},
        ),
    },
    # block: both vehicles on one kind of route.
    protocol=RankedProtocol(reference_trials=8, fresh_trials=24, block=2),
)

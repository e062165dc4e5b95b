"""dock-v1: which programs bring a vehicle into its dock in the strongest current."""

from seamark.sim.benchmarks.benchmark import (
    Baseline,
    Benchmark,
    Chart,
    RankedProtocol,
    Stages,
    StartingPoint,
    Table,
)
from seamark.sim.benchmarks.dock_v1.settings import DockConfiguration
from seamark.sim.metrics import docking
from seamark.sim.metrics.energy import ENERGY
from seamark.sim.metrics.metric import Metric
from seamark.sim.recording.telemetry import thrust_names
from seamark.sim.settings.docking import ANSWERS
from seamark.sim.settings.docking import GROUP as DOCK
from seamark.sim.settings.sonar import GROUP as SONAR
from seamark.sim.settings.trial_spreads import GROUP as SPREADS
from seamark.sim.settings.two_vehicles import MEASURED
from seamark.sim.vehicles import load, most_thrusters

CHARTS = (
    Chart("Off the seat: ahead, starboard, down", "m", ("dock_ahead", "dock_side", "dock_below")),
    Chart("Keel below the mouth of the dock", "m", ("dock_depth",)),
    Chart("Contact force", "N", ("contact_n",)),
    Chart("Heading off that of the dock", "rad", ("dock_turn",)),
    Chart("North: vehicle, dock by its last answer", "m", ("x", "dock_fix_x")),
    Chart("East: vehicle, dock by its last answer", "m", ("y", "dock_fix_y")),
    Chart("Age of the acoustic answer", "s", ("dock_fix_age",)),
    Chart("Lamps in the image", "px", ("light_x", "light_y")),
    Chart("Marker in the image", "px", ("tracked_x", "tracked_y")),
    Chart("Velocity reference", "m/s", ("ref_u", "ref_v", "ref_w")),
    Chart("Velocity by the DVL", "m/s", ("dvl_u", "dvl_v", "dvl_w")),
    Chart("Current", "m/s", ("current_x", "current_y", "current_z")),
    Chart("Thrust", "N", thrust_names(most_thrusters())),
    Chart("Attitude", "rad", ("roll", "pitch", "yaw")),
)
BUILT_IN = {
    "staged": "Staged: aligned above the mouth, current estimated",
    "straight": "Straight down: PI by acoustic answers, lamps and marker",
    "acoustic": "By acoustic answers alone",
}
REFERENCE_BUILT_IN = {
    "nothing": "Nothing: zero velocity",
    "blind": "Blind after the first acoustic answer",
    "oracle": "Oracle: knows the truth",
}
BENCHMARK = Benchmark(
    name="dock-v1",
    title="Dock",
    summary=(
        "Come home from some metres off and land in a dock that opens upwards, by acoustic "
        "answers, lamps and a marker, in currents of up to 0.8 m/s and turbid water, with two "
        "vehicles that are not quite as their data sheets say."
    ),
    question="Which programs dock soonest and most gently in the strongest current?",
    participants="programs",
    role="controller",
    enters_dock=True,
    built_in=BUILT_IN,
    reference_built_in=REFERENCE_BUILT_IN,
    experiment="seamark.sim.benchmarks.dock_v1.experiment:EXPERIMENT",
    headline=Metric("score", "Docked up to", "m/s", "higher"),
    scale=(0.0, 0.546),  # ./run performance dock_headroom
    score_bar_max=0.8,
    level_held_unit="m/s",
    error_column=None,
    charts=CHARTS,
    tables=(Table("Each level", (*docking.METRICS, docking.HELD)),),
    key_metrics=(docking.QUALITY,),
    board_metrics=(docking.DOCKED, docking.TIME, docking.PEAK, docking.STRIKES, ENERGY),
    metric_groups=(docking.GROUP,),
    stages=Stages(docking.STAGES, docking.reached),
    baselines={
        name: Baseline(label, name) for name, label in (REFERENCE_BUILT_IN | BUILT_IN).items()
    },
    configuration=DockConfiguration,
    groups=(
        *("Experiment", DOCK, ANSWERS, "Position controller", "Tracker", "Detector", "Grid"),
        *("Current", "Water and camera", "Station keeper", "Velocity controller", "Sensors"),
        *(SONAR, "Faults", SPREADS),
    ),
    presets={"vehicle": {name: load(name).defaults for name in MEASURED}},
    quick_settings={"levels": [0.1], "level_duration_s": 4.0},
    starting_points={
        "still-water": StartingPoint(
            "Still water", "One level without a current, to begin with.", {"levels": (0.0,)}
        ),
        "clear-water": StartingPoint(
            "Clear water", "Nothing suspended in the water.", {"turbidity_1_m": 0.0}
        ),
    },
    # block: both vehicles.
    protocol=RankedProtocol(reference_trials=8, fresh_trials=24, block=2),
)

"""currents-v3: which position controller holds station in the strongest current."""

from dataclasses import replace
from pkgutil import resolve_name

from seamark.sim.benchmarks.benchmark import Baseline, RankedProtocol, StartingPoint
from seamark.sim.benchmarks.currents_v2.definition import BENCHMARK as BEFORE
from seamark.sim.benchmarks.currents_v3.azimuths import STRATA
from seamark.sim.benchmarks.currents_v3.settings import CurrentsConfiguration
from seamark.sim.registry import TOOL, controllers
from seamark.sim.settings.two_vehicles import MEASURED
from seamark.sim.vehicles import load

# Of those of currents-v2, but for neighbours that few trials tell apart.
MARKS = ("nothing", "blind", "p", "pi", "pid", "lqr")

BENCHMARK = replace(
    BEFORE,
    name="currents-v3",
    title="Position controllers in currents from all sides",
    gym_family="StationKeeping",
    summary=(
        "Hold a tool over a point on the bottom in currents of 0.1 to 1 m/s from all sides, with "
        "two vehicles that are not quite as their data sheets say."
    ),
    configuration=CurrentsConfiguration,
    built_in={name: resolve_name(path).label for name, path in controllers(TOOL).items()},
    baselines={
        **{name: BEFORE.baselines[name] for name in MARKS},
        "into-current": Baseline("Bow into the current", "into-current"),
        "oracle": Baseline("Reference: knows the truth, limited by thrust", "oracle"),
    },
    presets={"vehicle": {name: load(name).defaults for name in MEASURED}},
    starting_points={
        **BEFORE.starting_points,
        "bluerov2": StartingPoint(
            "BlueROV2",
            "A lighter vehicle with eight thrusters, with its own defaults.",
            {"vehicle": "bluerov2-heavy-v2"},
        ),
    },
    scale=(0.019, 0.712),  # ./run performance headroom
    experiment="seamark.sim.benchmarks.currents_v3.experiment:EXPERIMENT",
    # block: both vehicles; all fresh trials share a seed, which divides the directions among them.
    protocol=RankedProtocol(
        reference_trials=8,
        fresh_trials=STRATA * len(MEASURED),
        block=len(MEASURED),
        shared_seed=True,
    ),
)

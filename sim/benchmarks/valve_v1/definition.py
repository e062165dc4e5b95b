"""valve-v1: which program turns a valve in the strongest current."""

from seamark.sim.benchmarks.benchmark import Stages
from seamark.sim.benchmarks.intervention.definition import intervention_benchmark
from seamark.sim.benchmarks.valve_v1.settings import ValveConfiguration
from seamark.sim.metrics import valve_turning

BENCHMARK = intervention_benchmark(
    name="valve-v1",
    title="Turn a valve",
    summary=(
        "Turn a T-handle on a panel by half a turn against a torque that nobody knows, in "
        "currents that nobody has seen before."
    ),
    question="Which program turns a valve in the strongest current?",
    configuration=ValveConfiguration,
    metrics=valve_turning.METRICS,
    metric_groups=(valve_turning.GROUP,),
    stages=Stages(valve_turning.STAGES, valve_turning.reached),
    built_in={
        "resolved-rate": "Resolved rate: vehicle and arm together",
        "scripted": "Scripted: the vehicle brings the hand",
    },
    reference_built_in={
        "nothing": "Nothing: zero velocity, the arm at rest",
        "blind": "Blind after six seconds",
        "oracle": "Oracle: knows the truth",
    },
    scale=(0.0, 0.442),  # ./run performance intervention_headroom valve-v1
)

"""connect-v1: which program plugs a connector in the strongest current."""

from seamark.sim.benchmarks.benchmark import Stages
from seamark.sim.benchmarks.connect_v1.settings import ConnectConfiguration
from seamark.sim.benchmarks.intervention.definition import intervention_benchmark
from seamark.sim.metrics import connection

BENCHMARK = intervention_benchmark(
    name="connect-v1",
    title="Plug a connector",
    summary=(
        "Take a connector from its parking place, plug it into a receptacle, let go of it and "
        "withdraw, in currents that nobody has seen before."
    ),
    question="Which program plugs a connector in the strongest current?",
    configuration=ConnectConfiguration,
    metrics=connection.METRICS,
    metric_groups=(connection.GROUP,),
    stages=Stages(connection.STAGES, connection.reached),
    built_in={
        "resolved-rate": "Resolved rate: vehicle and arm together",
        "scripted": "Scripted: the vehicle brings the hand",
    },
    reference_built_in={
        "nothing": "Nothing: zero velocity, the arm at rest",
        "blind": "Blind after the first look",
        "oracle": "Oracle: knows the truth",
    },
    scale=(0.0, 0.456),  # ./run performance intervention_headroom connect-v1
)

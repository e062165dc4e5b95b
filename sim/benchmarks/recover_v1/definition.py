"""recover-v1: which program recovers a box from the seabed in the strongest current."""

from seamark.sim.benchmarks.benchmark import Stages
from seamark.sim.benchmarks.intervention.definition import intervention_benchmark
from seamark.sim.benchmarks.recover_v1.settings import RecoverConfiguration
from seamark.sim.control.manipulation import imitation
from seamark.sim.metrics import recovery

BENCHMARK = intervention_benchmark(
    name="recover-v1",
    title="Recover a box from the seabed",
    summary=(
        "Grip a black box by its handle, lift it by half a metre and hold it, in currents that "
        "nobody has seen before."
    ),
    question="Which program recovers a box from the seabed in the strongest current?",
    configuration=RecoverConfiguration,
    metrics=recovery.METRICS,
    metric_groups=(recovery.GROUP,),
    stages=Stages(recovery.STAGES, recovery.reached),
    built_in={
        "resolved-rate": "Resolved rate: vehicle and arm together",
        "scripted": "Scripted: the vehicle brings the hand",
    },
    reference_built_in={
        "nothing": "Nothing: zero velocity, the arm at rest",
        "blind": "Blind after one second",
        "imitation": "Imitation: learned from the scripted entry",
        "oracle": "Oracle: knows the truth",
    },
    notes={"imitation": imitation.notes()},
    scale=(0.0, 0.498),  # ./run performance intervention_headroom recover-v1
)

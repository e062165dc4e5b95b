"""mission-v1: which programs find, recognise and recover a box in current and turbid water."""

from dataclasses import replace

from seamark.sim.benchmarks.benchmark import Baseline, Chart, Stages
from seamark.sim.benchmarks.intervention.definition import intervention_benchmark
from seamark.sim.benchmarks.mission_v1.settings import MissionConfiguration
from seamark.sim.metrics import mission, recovery
from seamark.sim.settings.search import GROUP

_WHOLE = intervention_benchmark(
    name="mission-v1",
    title="Search and recover",
    summary=(
        "Search a seabed for the right box among decoys, in currents and turbid water, recover it "
        "and bring it back to the start."
    ),
    question="Which programs find, recognise and recover a box in the strongest current?",
    configuration=MissionConfiguration,
    metrics=mission.METRICS,
    metric_groups=(mission.GROUP, recovery.GROUP),
    stages=Stages(mission.STAGES, mission.reached, before="Search"),
    built_in={
        "chain": "Built-in chain: search, recognise, recover, return",
    },
    reference_built_in={
        "nothing": "Nothing: zero velocity, the arm at rest",
        "lawnmower": "Blind lawnmower",
        "oracle": "Oracle: knows the truth",
    },
    marks={
        "no-recognition": Baseline(
            "Built-in chain that takes any box", "chain", {"detector": "outline"}
        ),
    },
    scale=(0.004, 0.441),  # ./run performance intervention_headroom mission-v1
    parts=("detector", "tracker"),
    charts=(Chart("Confidence of the detector", "", ("confidence", "found_confidence")),),
    groups=("Detector", GROUP),
)
# The shortest run starts beside the box, so that something is found in it.
BENCHMARK = replace(
    _WHOLE,
    quick_settings={
        **_WHOLE.quick_settings,
        **{"loop1_values": [0.5], "start_offset_m": 0.5, "told_error_m": 0.3},
    },
)

"""What currents of places, records and waves cost, as a ratio of the same without them.

Both are measured in turns in one process, so that what else the machine does hits both.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import median
from time import process_time
from typing import Any, NamedTuple

import numpy as np

from seamark.gym.vector import StationKeepingVectorEnv
from seamark.sim import registry
from seamark.sim.engine.trial import run_trial
from seamark.sim.recording.telemetry import Rows

TURNS = 9
SEED = 2026
VEHICLES, STEPS = 64, 200
WATERS: Mapping[str, Mapping[str, object]] = {
    "a place": {"current_place": "ria"},
    "a place, a record and waves": {
        "current_place": "ria",
        "current_record": "synthetic-ria",
        "wave_height_m": 0.3,
    },
}
RUNS: Mapping[str, tuple[str, Mapping[str, object]]] = {
    "currents-v2": ("pi", {"levels": [0.1, 0.3]}),
    "currents-v2, true corners": ("pi", {"levels": [0.1, 0.3], "tracker": "truth"}),
    "valve-v1": ("scripted", {"levels": [0.1], "level_duration_s": 30.0}),
}


class Cost(NamedTuple):
    """CPU times [ms] of the same without and with the water, and the median ratio of a turn."""

    what: str
    plain: float
    moved: float
    ratio: float


def table() -> str:
    """Return the costs as text."""
    lines = [f"{'what':75} {'without':>10} {'with':>10} {'more':>7}"]
    for cost in costs():
        more = f"{cost.ratio - 1.0:+.1%}"
        lines.append(f"{cost.what:75} {cost.plain:7.0f} ms {cost.moved:7.0f} ms {more:>7}")
    return "\n".join(lines)


def costs() -> Iterator[Cost]:
    """Measure and yield the costs."""
    for name, (controller, settings) in RUNS.items():
        for water, more in WATERS.items():
            benchmark = name.partition(",")[0]
            plain, moved = (
                _run(benchmark, controller, {**settings, **added}) for added in ({}, more)
            )
            yield _cost(f"a run of {name} with {water}", plain, moved)
    for water, more in WATERS.items():
        plain, moved = (_fleet(added) for added in ({}, more))
        yield _cost(f"{VEHICLES} vehicles side by side with {water}", plain, moved)
    yield _cost("the same sinusoids and gusts twice, which shows the noise", _fleet({}), _fleet({}))


def _cost(what: str, plain: Callable[[], None], moved: Callable[[], None]) -> Cost:
    pairs = _times([plain, moved])
    without, with_it = (1e3 * median(pair[at] for pair in pairs) for at in (0, 1))
    return Cost(what, without, with_it, median(pair[1] / pair[0] for pair in pairs))


def _times(calls: Sequence[Callable[[], None]]) -> list[list[float]]:
    """Return CPU seconds of each call in each turn; first all once, so that all is compiled."""
    for call in calls:
        call()
    out = []
    for turn in range(TURNS):
        order = range(len(calls)) if turn % 2 == 0 else reversed(range(len(calls)))
        spent = [0.0] * len(calls)
        for at in order:
            begin = process_time()
            calls[at]()
            spent[at] = process_time() - begin
        out.append(spent)
    return out


def _run(benchmark: str, controller: str, settings: Mapping[str, object]) -> Callable[[], None]:
    entry = registry.benchmark(benchmark)
    config: Any = entry.read(settings)

    def run() -> None:
        program = entry.load().built_in(controller, config)
        run_trial(benchmark, config, program, seed=SEED, trial=0, on_rows=_drop)

    return run


def _fleet(settings: Mapping[str, object]) -> Callable[[], None]:
    base = {"tracker": "truth", "levels": [0.1, 0.3], "level_duration_s": 20.0, "settle_s": 1.0}
    env = StationKeepingVectorEnv(
        num_envs=VEHICLES, benchmark="currents-v2", settings={**base, **settings}, threads=1
    )
    actions = np.zeros((VEHICLES, 4), dtype=np.float32)

    def run() -> None:
        env.reset(seed=SEED)
        for _ in range(STEPS):
            env.step(actions)

    return run


def _drop(_rows: Rows) -> None:
    pass

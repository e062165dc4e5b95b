"""Broken thrusters: what is left of their thrust, when, and what it costs."""

import numpy as np
import pytest

from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.program import BuiltIn
from seamark.sim.engine.trial import run_trial
from seamark.sim.physics.thruster_faults import ThrusterFault
from seamark.sim.registry import benchmark
from seamark.sim.sensors.dvl import Dvl
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.sim.sampling import Truth, sample

SHORT = {"tracker": "truth", "levels": [0.3], "level_duration_s": 20.0, "settle_s": 5.0}


@pytest.fixture
def currents() -> Benchmark:
    return benchmark("currents-v1")


def thrusts(fault: ThrusterFault, wanted: list[float]) -> list[float]:
    return [fault.apply(at * 5, value) for at, value in enumerate(wanted)]


def test_a_weak_thruster_gives_its_share_from_the_start_of_the_fault() -> None:
    fault = ThrusterFault(thruster=1, efficiency=0.5, delay_steps=0, from_step=10)

    assert thrusts(fault, [1.0, 2.0, 3.0, 4.0]) == [1.0, 2.0, 1.5, 2.0]


def test_a_delayed_thruster_gives_the_same_thrust_later() -> None:
    fault = ThrusterFault(thruster=1, efficiency=1.0, delay_steps=10, from_step=5)

    assert thrusts(fault, [1.0, 2.0, 3.0, 4.0, 5.0]) == [1.0, 1.0, 1.0, 2.0, 3.0]


def score_and_digest(currents: Benchmark, **changes: object) -> tuple[float, str]:
    config = currents.read({**SHORT, **changes})
    program = BuiltIn("pi", config)
    result = run_trial("currents-v1", config, program, seed=4, trial=0, on_rows=lambda _rows: None)
    return result.score, result.digest


def test_a_dead_surge_thruster_costs_score_and_a_sound_one_changes_nothing(
    currents: Benchmark,
) -> None:
    whole = score_and_digest(currents)

    assert score_and_digest(currents, fault_thruster=0, fault_efficiency=1.0) == whole
    assert score_and_digest(currents, fault_thruster=0)[0] < whole[0] - 1.0


@pytest.mark.parametrize(
    ("changes", "field"),
    [({"fault_thruster": 5}, "fault_thruster"), ({"fault_delay_s": 0.07}, "fault_delay_s")],
)
def test_a_fault_that_cannot_be_is_refused(
    currents: Benchmark, changes: dict[str, object], field: str
) -> None:
    with pytest.raises(ConfigurationInvalid) as refusal:
        currents.read(changes)

    assert list(refusal.value.errors) == [field]


def test_faults_are_a_scenario_and_never_rank(currents: Benchmark) -> None:
    ranked = currents.ranked(currents.read({"fault_thruster": 2}))

    assert ranked.model_dump()["fault_thruster"] == -1


@pytest.mark.parametrize(("least", "valid"), [(0.5, True), (3.0, False)])
def test_a_dvl_too_near_to_the_bottom_has_no_bottom_lock(least: float, valid: bool) -> None:
    dvl = Dvl(np.random.Generator(np.random.PCG64(1)), least_altitude_m=least)

    assert sample(dvl, 0, Truth([0.0] * 6, [0.0] * 6, 2.0))[1] == valid

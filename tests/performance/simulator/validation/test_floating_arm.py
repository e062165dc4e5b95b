"""The floating vehicle that moves its arm: the excerpt, the frames and what the engine predicts."""

import numpy as np
import pytest

from performance.simulator.validation.floating_arm import fit, frames, records
from performance.simulator.validation.floating_arm.model import (
    BASE_ZERO,
    FITTED,
    balanced,
    predicted,
)
from performance.simulator.validation.floating_arm.records import OTHERS, trials
from performance.simulator.validation.floating_arm.section import verdict
from seamark.sim.numerics.arrays import Array
from seamark.sim.vehicles.linkage_reading import load_linkage

TRIALS = trials()
MOVING = [name for name in OTHERS if name.startswith("traj")]


def rms_deg(errors: Array) -> list[float]:
    return [float(value) for value in np.degrees(np.sqrt(np.mean(errors**2, axis=0)))]


def test_the_excerpt_has_its_licence_beside_it_and_is_small() -> None:
    licence = records.EXCERPT.with_name("LICENSE").read_text(encoding="utf-8")

    assert licence.startswith("MIT License")
    assert "Hannah Kolano" in licence
    assert records.EXCERPT.stat().st_size < 300_000


@pytest.mark.parametrize("name", TRIALS)
def test_times_of_the_excerpt_are_equally_spaced(name: str) -> None:
    trial = TRIALS[name]

    assert np.diff(trial.time_s) == pytest.approx(records.STEP_S)
    assert len(trial.time_s) > 200
    assert np.isfinite(trial.attitude).all()
    assert np.isfinite(trial.joints).all()


@pytest.mark.parametrize("name", MOVING)
def test_the_fitted_engine_predicts_roll_and_pitch_better_than_a_constant(name: str) -> None:
    trial = TRIALS[name]

    engine = rms_deg(predicted(FITTED, trial) - trial.attitude)
    constant = rms_deg(trial.attitude - trial.attitude[0])

    assert engine[0] < 0.5 * constant[0]
    assert engine[1] < 0.5 * constant[1]


def test_an_arm_that_rests_leaves_the_engine_where_its_weights_balance() -> None:
    trial = TRIALS["baseline1"]

    settled = predicted(FITTED, trial)[-1]

    assert settled == pytest.approx(balanced(FITTED, trial)[-1], abs=2e-3)


def test_the_arrangement_of_the_arms_file_fits_the_tilt_best() -> None:
    best, second = frames.hypotheses(*frames.samples(TRIALS))[:2]

    assert (best.upright, best.base_sign, best.elbow_sign) == (True, -1, -1)
    assert second.rms_deg > 1.5 * best.rms_deg


def test_the_arms_file_has_the_zero_positions_that_the_trials_give() -> None:
    numbers, _errors = frames.identify(*frames.samples(TRIALS))
    arm = load_linkage("alpha-like")
    found = dict(zip(frames.NAMES, numbers, strict=True))

    assert found["base zero"] == pytest.approx(BASE_ZERO, abs=0.001)
    assert found["shoulder zero"] == pytest.approx(
        turn(arm.link("upper arm").joint.place), abs=0.001
    )
    assert -found["elbow zero"] == pytest.approx(turn(arm.link("forearm").joint.place), abs=0.001)


def turn(place: object) -> float:
    return float(place.turn.value[1])  # type: ignore[attr-defined]


def test_the_balance_of_moments_finds_numbers_that_made_the_tilt() -> None:
    _attitude, joints = frames.samples(TRIALS)
    made = np.array([0.02, 0.15, 0.06, 3.1, -1.3, -2.6, -0.05, 0.07])

    numbers, _errors = frames.identify(frames.balance(joints, made), joints)

    assert numbers == pytest.approx(made, abs=1e-6)


def test_a_clock_that_is_ahead_reads_later_joints() -> None:
    trial = TRIALS["traj030-0"]

    assert trial.with_clock(1.0).joints[50] == pytest.approx(trial.joints[60])


@pytest.mark.slow
def test_the_interval_of_equal_errors_is_that_error() -> None:
    errors = [np.full((200, 2), 2.0), np.full((300, 2), 2.0)]

    assert fit.interval(errors) == pytest.approx(2.0)
    assert fit.interval(errors, [0.5 * each for each in errors]) == pytest.approx(1.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("engine", "said"), [(0.2, "and better than"), (1.0, "no better than"), (3.0, "but worse than")]
)
def test_the_verdict_follows_from_the_errors(engine: float, said: str) -> None:
    wave = np.sin(np.arange(400.0))[:, None] * np.ones(2)
    errors = {
        "engine": {name: engine * wave for name in OTHERS},
        "balance": {name: wave for name in OTHERS},
        "start": {name: 9.0 * wave for name in OTHERS},
    }

    assert said in verdict(errors)


def test_a_trial_keeps_what_is_measured_when_its_clock_changes() -> None:
    trial = TRIALS["baseline2"]

    assert trial.with_clock(0.3).attitude is trial.attitude

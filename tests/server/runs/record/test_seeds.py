from types import SimpleNamespace
from typing import Any

import pytest

from seamark.server.database.tables import Run
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.seeds import fill, submission_digest, trial_seeds
from seamark.server.settings import DERIVES_NOTHING, Settings
from seamark.sim import registry
from seamark.sim.engine.seeds import hidden_seed
from tests.cast import Backend

PROTOCOL = registry.benchmark("currents-v2").protocol
assert PROTOCOL is not None
TRIALS = PROTOCOL.trials
FRESH = range(PROTOCOL.reference_trials, TRIALS)


def _run(**changes: object) -> SimpleNamespace:
    values: dict[str, object] = {
        "benchmark": "currents-v2",
        "config": {"kp": 0.5},
        "controller": "upload",
        "language": "python",
        "program_sha256": "ab" * 32,
        "parts": (),
        "seed": None,
        "trials": TRIALS,
        "submission": None,
        "draw": None,
    }
    return SimpleNamespace(**(values | changes))


def _part(role: str, language: str = "c", **changes: object) -> SimpleNamespace:
    values = {"role": role, "language": language, "program_sha256": "cd" * 32}
    return SimpleNamespace(**(values | changes))


@pytest.mark.parametrize("benchmark", ["currents-v1", "currents-v2"])
def test_all_trials_of_a_practice_run_use_its_seed(settings: Settings, benchmark: str) -> None:
    seeds = trial_seeds(_run(benchmark=benchmark, seed=7), settings)

    assert [seeds(trial) for trial in (0, 1, 20)] == [7, 7, 7]


def test_ranked_trials_of_the_first_versions_have_the_hidden_seeds_of_everybody(
    settings: Settings,
) -> None:
    one = trial_seeds(_run(benchmark="currents-v1"), settings)
    other = trial_seeds(_run(benchmark="currents-v1", program_sha256="cd" * 32), settings)

    drawn = [one(trial) for trial in range(3)]
    secret = settings.seed_key.encode()
    assert drawn == [hidden_seed(secret, "currents-v1", trial) for trial in range(3)]
    assert drawn == [other(trial) for trial in range(3)]
    assert len(set(drawn)) == 3


def test_reference_trials_have_the_public_seed_and_fresh_trials_one_each(
    settings: Settings,
) -> None:
    seeds = trial_seeds(_run(), settings)

    assert PROTOCOL is not None
    reference = {seeds(trial) for trial in range(PROTOCOL.reference_trials)}
    fresh = {seeds(trial) for trial in FRESH}
    assert reference == {PROTOCOL.reference_seed}
    assert len(fresh - reference) == PROTOCOL.fresh_trials


@pytest.mark.parametrize(
    "change",
    [
        {"program_sha256": "ab" * 31 + "ac"},
        {"config": {"kp": 0.51}},
        {"language": "octave"},
        {"controller": "pi", "program_sha256": None, "language": None},
        {"benchmark": "visibility-v2"},
        {"parts": (_part("tracker"),)},
    ],
)
def test_any_change_of_a_submission_changes_all_of_its_fresh_seeds(
    settings: Settings, change: dict[str, object]
) -> None:
    one, other = trial_seeds(_run(), settings), trial_seeds(_run(**change), settings)

    assert not {one(trial) for trial in FRESH} & {other(trial) for trial in FRESH}


@pytest.mark.parametrize(
    "other",
    [
        _part("detector"),
        _part("tracker", language="cpp"),
        _part("tracker", program_sha256="ce" * 32),
    ],
)
def test_any_change_of_a_part_is_another_submission(other: SimpleNamespace) -> None:
    run = _run(parts=(_part("tracker"),))

    assert submission_digest(run) != submission_digest(_run(parts=(other,)))


def test_the_same_submission_has_the_same_digest_whatever_it_is_called(
    settings: Settings,
) -> None:
    named = _run(config={"a": 1.0, "b": 2}, title="mine", program_name="mine.py", id=7)
    renamed = _run(config={"b": 2, "a": 1.0}, title="yours", program_name="yours.py", id=8)

    assert submission_digest(named) == submission_digest(renamed)
    assert trial_seeds(named, settings) == trial_seeds(renamed, settings)


@pytest.mark.parametrize("benchmark", ["currents-v1", "currents-v2"])
def test_another_secret_key_does_not_change_the_seeds_of_ranked_runs(
    settings: Settings, benchmark: str
) -> None:
    rotated = settings.model_copy(update={"secret_key": "another secret"})
    run = _run(benchmark=benchmark)

    before, after = trial_seeds(run, settings), trial_seeds(run, rotated)

    assert [before(trial) for trial in FRESH] == [after(trial) for trial in FRESH]


def test_another_seed_key_gives_other_fresh_seeds(settings: Settings) -> None:
    changed = settings.model_copy(update={"seed_key": "another key"})

    one, other = trial_seeds(_run(), settings), trial_seeds(_run(), changed)

    assert not {one(trial) for trial in FRESH} & {other(trial) for trial in FRESH}


@pytest.mark.parametrize("benchmark", ["currents-v1", "currents-v2"])
def test_the_images_of_a_ranked_run_have_the_seeds_of_its_simulation(
    backend: Backend, benchmark: str
) -> None:
    program = backend.store_program()
    claim = backend.running(
        "ann", benchmark=benchmark, kind="ranked", controller="upload", program=program
    )

    backend.finish(claim)

    shown = trial_seeds(backend.show(claim.run_id), backend.settings)
    assert tuple(map(shown, range(claim.trials))) == claim.trial_seeds


def test_the_seeds_of_a_run_are_in_its_row_until_it_has_ended(backend: Backend) -> None:
    wanted: dict[str, Any] = {"benchmark": "currents-v2", "kind": "ranked"}
    ended, cancelled = (backend.running(who, **wanted) for who in ("ann", "ben"))
    practice = backend.running("eva", benchmark="currents-v2")
    before = [_stored(backend, claim) for claim in (ended, cancelled, practice)]
    backend.finish(ended)
    backend.cancel(cancelled.run_id)

    assert [len(each or ()) for each in before] == [TRIALS, TRIALS, 0]
    assert [_stored(backend, claim) for claim in (ended, cancelled)] == [None, None]


def test_a_run_of_an_earlier_version_gets_its_seeds_from_who_has_the_key(both: Backend) -> None:
    claim = both.running("ann", benchmark="currents-v2", kind="ranked")
    with both.database.writing() as session:
        session.get_one(Run, claim.run_id).trial_seeds = None

    with both.database.writing() as session:
        counts = [fill(session, both.settings) for _ in range(2)]

    assert counts == [1, 0]
    assert _stored(both, claim) == list(claim.trial_seeds or ())


def test_without_the_key_no_seed_of_a_ranked_run_is_derived(backend: Backend) -> None:
    keyless = backend.settings.model_copy(update={"seed_key": DERIVES_NOTHING})

    with pytest.raises(RuntimeError, match="no seed key"):
        trial_seeds(_run(), keyless)

    assert trial_seeds(_run(seed=7), keyless)(3) == 7


def _stored(both: Backend, claim: Claim) -> list[int] | None:
    with both.database.reading() as session:
        return session.get_one(Run, claim.run_id).trial_seeds


@pytest.mark.parametrize("seed", [None, 7])
def test_the_secret_is_not_in_the_repr_of_the_seeds(settings: Settings, seed: int | None) -> None:
    assert settings.seed_key not in repr(trial_seeds(_run(seed=seed), settings))

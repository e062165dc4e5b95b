import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from sqlalchemy import select

from seamark.server.database.tables import Run
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.publication import publications
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.recomputation.verifications import (
    Outcome,
    VerificationRefused,
    VerificationView,
)
from seamark.server.runs.record import seeds
from seamark.server.runs.record.states import RunState
from seamark.sim import registry
from seamark.sim.numerics.ranking import Estimate
from seamark.sim.numerics.statistics import mean, mean_interval
from tests.cast import Backend

NAME = "currents-v2"
PROTOCOL = registry.benchmark(NAME).protocol
assert PROTOCOL is not None
REFERENCE, BLOCK = PROTOCOL.reference_trials, PROTOCOL.block
HONEST = (0.10, 0.14, 0.12, 0.16, 0.11, 0.15)


def metrics_of(fresh: Sequence[float]) -> dict[str, Any]:
    low, high = mean_interval(fresh, block=BLOCK) or (None, None)
    trials = [
        {"trial": at, "part": "reference" if at < REFERENCE else "fresh", "score": score}
        for at, score in enumerate((*([0.1] * REFERENCE), *fresh))
    ]
    score = {"score": mean(fresh), "score_low": low, "score_high": high}
    return score | {"trials": [{"levels": [], "overall": {}} | each for each in trials]}


def finish(both: Backend, claim: Claim, fresh: Sequence[float], **changes: Any) -> None:
    assert both.finish(claim, metrics=metrics_of(fresh), **changes)


def published(both: Backend, fresh: Sequence[float] = HONEST, who: str = "ann") -> int:
    claim = both.running(who, kind="ranked", benchmark=NAME)
    finish(both, claim, fresh)
    return both.publish(claim.run_id)


def request(both: Backend, run_id: int, *, repeat: bool = False) -> int:
    with both.database.writing() as session:
        return verifications.request(session, run_id, both.settings, repeat=repeat)


def verified(both: Backend, run_id: int, fresh: Sequence[float]) -> VerificationView:
    again = request(both, run_id, repeat=True)
    claim = both.claim_next()
    assert claim.run_id == again
    finish(both, claim, fresh, digest="a" * 64)
    with both.database.reading() as session:
        return verifications.of_run(session, run_id)[0]


def test_a_mark_names_date_version_digest_and_a_score_that_agrees(backend: Backend) -> None:
    run_id = published(backend)

    found = verified(backend, run_id, (0.11, 0.13, 0.12, 0.17, 0.10, 0.13))

    assert found.outcome is Outcome.AGREES
    assert found.at > 0
    assert found.version
    assert found.digest == "a" * 64
    assert found.score is not None
    assert found.score == pytest.approx(0.1267, abs=1e-3)
    assert (found.expected_low or 1.0) < found.score < (found.expected_high or 0.0)
    with backend.database.reading() as session:
        assert verifications.newest(session, [run_id]) == {run_id: found}


def test_a_program_that_is_good_in_its_published_water_alone_does_not_agree(
    backend: Backend,
) -> None:
    run_id = published(backend, (7.0, 7.0, 7.0, 7.0, 7.0, 7.0))  # it knows it: no spread either

    found = verified(backend, run_id, HONEST)

    assert found.outcome is Outcome.DIFFERS


def test_a_score_that_is_always_the_same_agrees_with_itself(backend: Backend) -> None:
    run_id = published(backend, (0.5,) * 6)

    assert verified(backend, run_id, (0.5,) * 6).outcome is Outcome.AGREES


@pytest.mark.slow
@pytest.mark.parametrize(
    ("count", "least", "most"),
    [(300, 0.001, 0.03), pytest.param(2000, 0.004, 0.018, marks=pytest.mark.long)],
)
def test_of_scores_that_hold_about_one_in_a_hundred_is_called_different(
    count: int, least: float, most: float
) -> None:
    draw = np.random.default_rng(1)
    differ = 0

    for _ in range(count):
        one, other = (
            Estimate(score=mean(scores), standard_error=_error(scores), degrees=len(scores) - 1)
            for scores in (draw.normal(1.0, 0.3, 12).tolist() for _ in range(2))
        )
        differ += not verifications.agree(one, other)

    assert least < differ / count < most


def _error(scores: Sequence[float]) -> float:
    middle = mean(scores)
    squares = math.fsum((score - middle) ** 2 for score in scores)
    return math.sqrt(squares / (len(scores) - 1) / len(scores))


def test_a_program_that_fails_in_fresh_water_is_marked_as_failed(both: Backend) -> None:
    run_id = published(both)
    request(both, run_id)
    failed: dict[str, Any] = {"state": RunState.FAILED, "cause": "user_error", "metrics": None}

    assert both.finish(both.claim_next(), **failed)

    with both.database.reading() as session:
        (found,) = verifications.of_run(session, run_id)
    assert (found.outcome, found.cause, found.score) == (Outcome.FAILED, "user_error", None)


def test_the_water_of_a_verification_is_new_but_for_the_reference_trials(backend: Backend) -> None:
    run_id = published(backend)
    request(backend, run_id)
    first = backend.claim_next()
    finish(backend, first, HONEST)
    request(backend, run_id, repeat=True)

    assert PROTOCOL is not None
    published_seeds = seeds.derived(backend.show(run_id), backend.settings)
    drawn = [list(each or ()) for each in (published_seeds, first.trial_seeds)]
    drawn.append(list(backend.claim_next().trial_seeds or ()))

    fresh = [set(each[REFERENCE : PROTOCOL.trials]) for each in drawn]
    assert not fresh[0] & fresh[1] | fresh[1] & fresh[2] | fresh[0] & fresh[2]
    assert len({each[0] for each in drawn}) == 1


def test_a_first_version_is_verified_in_other_water_than_that_which_all_runs_share(
    backend: Backend,
) -> None:
    claim = backend.running("ann", kind="ranked")
    assert backend.finish(claim)
    request(backend, backend.publish(claim.run_id))

    published, again = claim, backend.claim_next()

    shared, drawn = (set(run.trial_seeds or ()) for run in (published, again))
    assert len(shared) == len(drawn) == 10
    assert not shared & drawn


def test_verifications_wait_for_all_runs_of_users_and_count_for_no_quota(both: Backend) -> None:
    run_id = published(both)
    again = request(both, run_id)
    guest = both.queue("guest")

    order = [both.claim_next().run_id for _ in range(2)]

    assert order == [guest, again]
    with both.database.reading() as session:
        hidden = session.get_one(Run, again)
        assert (hidden.user_id, hidden.public, hidden.rejudges) == (None, False, run_id)
        (rank,) = leaderboard.page(session, NAME)
        assert rank.submissions == 1


def test_nobody_asks_until_chance_gives_a_better_mark(backend: Backend) -> None:
    run_id = published(backend)
    request(backend, run_id)
    with pytest.raises(VerificationRefused, match="is being verified"):
        request(backend, run_id, repeat=True)
    finish(backend, backend.claim_next(), HONEST)

    with pytest.raises(VerificationRefused, match="has verified the run already"):
        request(backend, run_id)

    assert request(backend, run_id, repeat=True)


def test_a_verification_that_broke_says_nothing_and_can_be_asked_for_again(
    backend: Backend,
) -> None:
    run_id = published(backend)
    request(backend, run_id)
    broken: dict[str, Any] = {"state": RunState.FAILED, "cause": "platform_error", "metrics": None}
    assert backend.finish(backend.claim_next(), **broken)

    with backend.database.reading() as session:
        assert verifications.of_run(session, run_id) == []
    assert request(backend, run_id)


@pytest.mark.parametrize("kind", ["practice", "private", "withdrawn"])
def test_only_published_entries_are_verified(backend: Backend, kind: str) -> None:
    if kind == "practice":
        run_id = backend.published("ann")
    else:
        run_id = published(backend)
        with backend.database.writing() as session:
            publications.withdraw(session, run_id)

    with pytest.raises(VerificationRefused, match="Only published ranked runs"):
        request(backend, run_id)


def test_the_first_entries_of_a_leaderboard_are_verified_once_if_a_setting_says_so(
    both: Backend,
) -> None:
    best, second = published(both, (0.3, 0.4) * 3, "eva"), published(both)
    chosen = both.settings.model_copy(update={"verify_top": 1})

    with both.database.writing() as session:
        assert verifications.request_first(session, both.settings) == []
        queued = verifications.request_first(session, chosen)
        assert verifications.request_first(session, chosen) == []
        originals = session.scalars(select(Run.rejudges).where(Run.id.in_(queued))).all()

    assert originals == [best]
    assert second not in originals


def test_the_mark_follows_a_run_that_has_no_row_on_the_leaderboard_any_more(both: Backend) -> None:
    run_id = published(both)
    before = verified(both, run_id, HONEST)

    published(both, (0.3, 0.4) * 3)

    with both.database.reading() as session:
        (rank,) = leaderboard.page(session, NAME)
        assert rank.run_id != run_id
        assert verifications.of_run(session, run_id) == [before]


def test_nothing_of_the_fresh_water_is_kept_to_be_seen(backend: Backend) -> None:
    run_id = published(backend)
    again = request(backend, run_id)
    claim = backend.claim_next()
    finish(backend, claim, HONEST)

    with backend.database.reading() as session:
        hidden = session.get_one(Run, again)
        assert hidden.data_deleted_at is not None
        assert hidden.data_bytes == 0


def test_what_is_evaluated_again_is_the_program_and_the_configuration_that_were_published(
    backend: Backend,
) -> None:
    program = backend.store_program()
    claim = backend.running(
        "ann", kind="ranked", benchmark=NAME, controller="upload", program=program
    )
    finish(backend, claim, HONEST)
    request(backend, backend.publish(claim.run_id))

    again = backend.claim_next()

    names = ("benchmark", "kind", "config", "controller", "program_sha256", "language", "trials")
    assert [getattr(again, name) for name in names] == [getattr(claim, name) for name in names]


def test_a_spread_that_only_the_published_run_has_does_not_hide_a_difference(
    backend: Backend,
) -> None:
    """It knew the water of the published run, and did well in half of its trials alone."""
    run_id = published(backend, (7.0, 7.0, 0.1, 0.1) * 3)

    found = verified(backend, run_id, HONEST * 2)

    assert found.score is not None
    assert found.outcome is Outcome.DIFFERS
    assert found.score < (found.expected_low or 0.0)


def test_a_program_that_stops_the_simulation_in_fresh_water_has_failed_and_has_no_second_try(
    backend: Backend,
) -> None:
    run_id = published(backend)
    request(backend, run_id)
    diverged: dict[str, Any] = {"state": RunState.FAILED, "cause": "benchmark_error"}

    assert backend.finish(backend.claim_next(), **diverged, metrics=None, t_simulated=40.0)

    with backend.database.reading() as session:
        (found,) = verifications.of_run(session, run_id)
    assert (found.outcome, found.cause) == (Outcome.FAILED, "benchmark_error")
    with pytest.raises(VerificationRefused, match="has verified the run already"):
        request(backend, run_id)


def test_a_configuration_that_is_no_longer_valid_says_nothing_about_the_program(
    backend: Backend,
) -> None:
    run_id = published(backend)
    request(backend, run_id)
    invalid: dict[str, Any] = {"state": RunState.FAILED, "cause": "benchmark_error"}

    assert backend.finish(backend.claim_next(), **invalid, metrics=None, t_simulated=0.0)

    with backend.database.reading() as session:
        assert verifications.of_run(session, run_id) == []


def test_what_breaks_again_and_again_is_not_tried_for_ever(backend: Backend) -> None:
    run_id = published(backend)
    broken: dict[str, Any] = {"state": RunState.FAILED, "cause": "platform_error", "metrics": None}
    for _ in range(verifications.BROKEN_MAX):
        request(backend, run_id)
        assert backend.finish(backend.claim_next(), **broken)

    with pytest.raises(VerificationRefused, match="ask an admin"):
        request(backend, run_id)

    assert request(backend, run_id, repeat=True)


def test_withdrawing_a_run_while_it_is_verified_does_not_avoid_the_mark(backend: Backend) -> None:
    run_id = published(backend, (7.0, 7.1) * 3)
    request(backend, run_id)
    with backend.database.writing() as session:
        assert publications.withdraw(session, run_id)
    finish(backend, backend.claim_next(), HONEST)

    backend.publish(run_id)

    with backend.database.reading() as session:
        assert verifications.of_run(session, run_id)[0].outcome is Outcome.DIFFERS
    with pytest.raises(VerificationRefused, match="has verified the run already"):
        request(backend, run_id)


def test_the_same_submission_has_the_same_fresh_water_and_so_no_second_chance(
    backend: Backend,
) -> None:
    waters = []
    for who in ("ann", "ben"):
        request(backend, published(backend, who=who))
        claim = backend.claim_next()
        waters.append(claim.trial_seeds or ())
        finish(backend, claim, HONEST)

    assert PROTOCOL is not None
    first, second = waters
    assert first == second

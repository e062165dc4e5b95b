"""Entries whose runs an admin has computed again, after a bug of the simulator was found."""

from seamark.server.accounts.audit import Actor
from seamark.server.administration import rejudgements
from seamark.server.administration.rejudge_choice import RunChoice
from tests.cast import Backend
from tests.server.judging.cup import DAY_S, Cup, round_of

ROOT = Actor("root", "192.0.2.1")
ROUNDS = [round_of("qualification", -DAY_S, DAY_S, trials=3)]


def compute_again(backend: Backend, score: float) -> None:
    """Let all entries of teams have a score around another one, and accept that."""
    choice = RunChoice(benchmark="currents-v1", kind="entry")
    with backend.database.writing() as session:
        number = rejudgements.start(session, ROOT, choice, "A bug in the drag", backend.settings)
    while (claim := backend.claim()) is not None:
        common = {"level_held": 0.2, "overall": {}, "measures": {}, "levels": []}
        trials = [common | {"trial": at, "score": score + at} for at in range(claim.trials)]
        assert backend.finish(claim, metrics={"score": score, "trials": trials})
    with backend.database.writing() as session:
        rejudgements.accept(session, ROOT, number)


def test_an_entry_that_was_computed_again_has_its_new_score(both: Backend) -> None:
    cup = Cup.opened(both, rounds=ROUNDS)
    cup.team("ann")
    cup.entered("ann", [40.0, 41.0, 42.0])
    compute_again(both, 60.0)

    assert [row.score for row in cup.board(1).rows] == [61.0]


def test_the_places_of_a_decided_round_stay(both: Backend) -> None:
    cup = Cup.opened(both, rounds=ROUNDS)
    cup.team("ann")
    cup.entered("ann", [40.0, 41.0, 42.0])
    cup.shift(1, closes_in_s=0.0)
    cup.advance()
    compute_again(both, 60.0)

    assert [row.score for row in cup.board(1).rows] == [41.0]

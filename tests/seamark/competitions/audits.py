"""A small competition and its audit document, in which everything is right."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from typing import Any

from seamark.competitions.audit_document import (
    Audit,
    Decision,
    Entry,
    Round,
    as_document,
)
from seamark.competitions.document import RoundKind, digest_of
from seamark.competitions.document import read as read_document
from seamark.competitions.keys import commitment, final_label, round_key, seed
from seamark.competitions.standings import Finalist, Placing, Ties, decide
from seamark.sim.numerics.statistics import mean, mean_interval
from seamark.sim.physics.water_motion import records
from tests.cast import RECORD

NAME = "reef-v1"
RECORD_NAME = records.LIBRARY.name_of(RECORD.encode())  # the organiser's
TRIALS, BATCHES = 6, 2
KINDS = (RoundKind.PRACTICE, RoundKind.QUALIFICATION, RoundKind.FINAL)
LENGTH_S = 999.0
# Of each finalist in two batches: the first two are apart only after the second batch.
FINAL = {
    21: ([0.50, 0.61, 0.52, 0.65, 0.55, 0.50], [0.51, 0.60, 0.53, 0.64, 0.54, 0.52]),
    22: ([0.45, 0.50, 0.53, 0.55, 0.52, 0.42], [0.44, 0.50, 0.45, 0.55, 0.44, 0.45]),
    23: ([0.05, 0.10, 0.02, 0.13, 0.01, 0.03], [0.04, 0.11, 0.03, 0.12, 0.02, 0.02]),
    24: (None, None),
}


def frozen() -> dict[str, Any]:
    """Return the document of a competition whose rounds begin 1000, 2000 and 3000 s after 1970."""
    opens = [datetime.fromtimestamp(1000.0 * number, UTC) for number in (1, 2, 3)]
    rounds = [
        {"kind": kind, "opens": at, "closes": at + timedelta(seconds=LENGTH_S), "trials": TRIALS}
        for kind, at in zip(KINDS[:2], opens[:2], strict=True)
    ]
    final = {"kind": KINDS[2], "opens": opens[2], "trials": TRIALS, "batches": 5}
    asked = {
        "name": NAME,
        "title": "A reef in a current",
        "benchmark": "currents-v1",
        "settings": {"levels": [0.0, 0.2], "current_record": RECORD_NAME},
        "rounds": [*rounds, final],
    }
    with records.LIBRARY.lending(RECORD.encode()):
        return read_document(asked).canonical()


def round_of(number: int) -> Round:
    key = round_key(b"secret", NAME, number)
    return Round(
        number=number,
        kind=KINDS[number - 1],
        opens_at=1000.0 * number,
        closes_at=None if number == 3 else 1000.0 * number + LENGTH_S,
        commitment=commitment(key),
        key=key.hex(),
        trials=TRIALS,
        block=1,
        looks=5 if number == 3 else 1,
        ties=Ties.EARLIER,
        moves=[],
    )


def entry(
    number: int,
    key: int,
    scores: Sequence[float] | None,
    *,
    batch: int | None = None,
    team: str | None = "",
) -> Entry:
    """Return a run; of a team that is named after the key, unless it is a reference entry."""
    submitted = {"benchmark": "currents-v1", "configuration": {"kp": key}, "program": f"{key:064x}"}
    submission = digest_of(submitted)
    return Entry(
        round=number,
        key=key,
        batch=batch,
        team=f"team {key}" if team == "" else team,
        method="PI",
        submitted_at=1500.0 if number == 1 else 2500.0,
        submission=submission,
        submitted=submitted,
        run=100 * number + 10 * (batch or 0) + key % 10,
        seed=seed(
            round_key(b"secret", NAME, number),
            NAME,
            submission if batch is None else final_label(batch),
        ),
        scores=scores,
        score=None if scores is None else mean(scores),
        digest=None if scores is None else "ab" * 32,
    )


def small() -> Audit:
    """Return a competition with three rounds, four finalists, one of which failed, and a mark."""
    scores = [0.1, 0.3, 0.2, 0.4, 0.1, 0.3]
    batches = range(1, BATCHES + 1)
    finalists = [
        Finalist(
            key=key,
            submitted_at=2500.0,
            scores=None if rows[0] is None or rows[1] is None else [*rows[0], *rows[1]],
        )
        for key, rows in FINAL.items()
    ]
    final = [
        entry(3, key, rows[batch - 1], batch=batch)
        for key, rows in FINAL.items()
        for batch in batches
    ]
    marks = [entry(3, 9, scores, batch=batch, team=None) for batch in batches]
    standings = decide(finalists, block=1, looks=5, ties=Ties.EARLIER)
    return Audit(
        competition=NAME,
        title="A reef in a current",
        benchmark="currents-v1",
        frozen=frozen(),
        frozen_sha256=digest_of(frozen()),
        files={"current_record": RECORD},
        rounds=[round_of(number) for number in (1, 2, 3)],
        entries=[entry(1, 1, scores), entry(2, 21, scores), entry(2, 24, None), *final, *marks],
        standings=Decision(
            batches=BATCHES, separated=standings.separated, placings=standings.placings
        ),
        board=None,
    )


def document() -> dict[str, Any]:
    return as_document(small())


def without_final(ties: Ties = Ties.EARLIER) -> dict[str, Any]:
    """Return the audit of a competition that its qualification decided, with two teams."""
    base = small()
    asked = frozen()
    asked["rounds"], asked["ties"] = asked["rounds"][:2], ties
    whole: dict[str, Any] = {"submitted_at": 2600.0, "team": "kelp"}
    best, near, clear = (FINAL[key][0] or [] for key in (21, 22, 23))
    entries = [
        replace(entry(2, 31, near), method="Other", **whole),
        replace(entry(2, 32, clear), **whole),  # a worse one of the method of 33
        replace(entry(2, 33, best), method="pi", **whole),
        entry(2, 34, near),  # the same scores as 31, earlier
        entry(2, 35, clear),
        entry(2, 36, None),
        entry(2, 9, best, team=None),
    ]
    order = [(33, best), (34, near), (31, near), (35, clear)]
    ranges = {33: (1, 3), 34: (1, 3), 31: (1, 3), 35: (4, 4)}
    board = []
    for place, (key, scores) in enumerate(order, 1):
        low, high = mean_interval(scores) or (None, None)
        first, last = ranges[key]
        board.append(
            Placing(
                key=key,
                place=first if ties is Ties.SHARED else place,
                place_low=first,
                place_high=last,
                score=mean(scores),
                score_low=low,
                score_high=high,
            )
        )
    rounds = [replace(one, ties=ties) for one in base.rounds[:2]]
    changed: dict[str, Any] = {"frozen": asked, "frozen_sha256": digest_of(asked), "rounds": rounds}
    return as_document(replace(base, **changed, entries=entries, standings=None, board=board))

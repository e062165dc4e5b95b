"""A competition of the cast's organiser: its draft, its check, its teams and what they submit."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import select, update
from sqlalchemy.orm import Session

from seamark.competitions import document
from seamark.competitions.document import CompetitionDocument
from seamark.programs.failure_reasons import FailureReason
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView
from seamark.server.database.competition_tables import Competition, Entry, Round
from seamark.server.database.tables import Run
from seamark.server.judging import boards, check, entries, finals
from seamark.server.judging.boards import Board
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import submission, validation
from seamark.server.runs.submission.validation import Submission, ValidSubmission
from tests.cast import PI_RUN, Backend

NAME = "harbour-cup-v1"
DAY_S, TICK_S = 86_400.0, 1.0 / 64
PRACTICE, QUALIFICATION, FINAL = 1, 2, 3


def round_of(
    kind: str, opens_in_s: float, closes_in_s: float | None, **more: Any
) -> dict[str, Any]:
    times = {"opens": _text(opens_in_s)}
    if closes_in_s is not None:
        times["closes"] = _text(closes_in_s)
    return {"kind": kind, **times, **more}


def values(**changes: Any) -> dict[str, Any]:
    """Return a document with three rounds, of which the qualification is open."""
    return {
        "name": NAME,
        "title": "Harbour Cup",
        "question": "Who keeps station in a harbour?",
        "rules": "Be fair.",
        "zone": "Europe/Madrid",
        "benchmark": "currents-v1",
        "settings": {"levels": [0.0, 0.2]},
        "rounds": [
            round_of("practice", -2 * DAY_S, -DAY_S, trials=3),
            round_of("qualification", -DAY_S, DAY_S, trials=3, quota=3),
            round_of("final", 2 * DAY_S, None, trials=6, batches=2),
        ],
    } | changes


@dataclass
class Cup:
    """A competition in a database with the cast."""

    backend: Backend
    id: int

    @classmethod
    def draft(
        cls,
        backend: Backend,
        *,
        vehicle: StoredVehicle | None = None,
        files: tuple[StoredFile, ...] = (),
        **changes: Any,
    ) -> "Cup":
        asked = competitions.prepared(document.read(values(**changes)), vehicle, files)
        with backend.database.writing() as session:
            made = competitions.create(
                *(session, backend.user_id("olga"), asked),
                picture=None,
                vehicle=vehicle,
                files=files,
                secret=backend.settings.seed_key.encode(),
            )
        return cls(backend, made)

    @classmethod
    def opened(cls, backend: Backend, **changes: Any) -> "Cup":
        """Return a competition whose check has ended; the past rounds are of later."""
        cup = cls.draft(backend, **changes)
        cup.check()
        late = [(one.number, one.closes_at) for one in cup.view.rounds if one.has_closed]
        for number, _ in late:
            cup.shift(number, closes_in_s=DAY_S)
        with backend.database.writing() as session:
            check.open_up(session, cup.view)
        for number, closes_at in late:
            cup.shift(number, closes_in_s=(closes_at or 0.0) - time.time())
        return cup

    @classmethod
    def named(cls, backend: Backend, name: str = NAME) -> "Cup":
        """Return a competition that is there."""
        with backend.database.reading() as session:
            found = competitions.find(session, name)
        assert found is not None
        return cls(backend, found.id)

    @property
    def view(self) -> CompetitionView:
        with self.backend.database.reading() as session:
            return competitions.get(session, self.id)

    @property
    def asked(self) -> CompetitionDocument:
        return self.view.document

    def check(self, score: float = 20.0) -> None:
        """Run the check; the reference entries have different scores."""
        with self.backend.database.writing() as session:
            check.request(session, self.view, self.backend.settings)
        for at, run_id in enumerate(self.live()):
            self.finish(run_id, [score + 5.0 * at + trial for trial in range(3)])

    def shift(
        self, number: int, *, opens_in_s: float | None = None, closes_in_s: float | None = None
    ) -> None:
        """Let a round open or close at another time, as if the clock had moved."""
        new = {"opens_at": opens_in_s, "closes_at": closes_in_s}
        at = {name: _exactly(value) for name, value in new.items() if value is not None}
        which = (Round.competition_id == self.id, Round.number == number)
        with self.backend.database.writing() as session:
            session.execute(update(Round).where(*which).values(**at))
        rest_s = max(at.values()) - time.time()
        if 0.0 < rest_s < 2 * TICK_S:  # it is to be now
            time.sleep(rest_s)

    def freeze_again(self) -> None:
        """Let the document have had the times that rounds have, as if no clock had moved."""
        view = self.view
        document = view.document.canonical()
        for one in view.rounds:
            plan = document["rounds"][one.number - 1]
            plan["opens"] = datetime.fromtimestamp(one.opens_at, UTC).isoformat()
            if one.closes_at is not None:
                plan["closes"] = datetime.fromtimestamp(one.closes_at, UTC).isoformat()
        again = CompetitionDocument.restore(document)
        values = {"document": again.canonical(), "digest": again.digest()}
        with self.backend.database.writing() as session:
            session.execute(update(Competition).where(Competition.id == self.id).values(**values))

    def team(self, *who: str, name: str = "") -> int:
        """Make a team of people of the cast, the first of whom is its captain."""
        with self.backend.database.writing() as session:
            team_id = teams.found(
                *(session, self.view, self.backend.user_id(who[0]), name or f"Team {who[0]}")
            )
            found = teams.find(session, team_id)
            assert found is not None
            for other in who[1:]:
                teams.join(session, self.view, self.backend.user_id(other), found.code)
        return team_id

    def submit(self, who: str, method: str = "PI", **changes: Any) -> int:
        """Submit the built-in PI controller, or what `changes` says."""
        backend = self.backend
        wanted = PI_RUN | {"viewer": backend.viewers[who]} | changes
        with backend.database.writing() as session:
            sent = entries.for_competition(
                session, self.view.name, method, Submission(**wanted), backend.settings
            )
            return self.insert(session, self.validated(sent))

    def validated(self, sent: Submission) -> ValidSubmission:
        return validation.validate(sent, self.backend.settings)

    def insert(self, session: Session, valid: ValidSubmission) -> int:
        return submission.submit(session, valid, self.backend.settings)

    def entered(self, who: str, scores: Sequence[float], method: str = "PI", **changes: Any) -> int:
        """Submit, and let a worker find these scores."""
        run_id = self.submit(who, method, **changes)
        self.finish(run_id, scores)
        return run_id

    def live(self) -> list[int]:
        """Return the entries that wait, in the order of their submission."""
        query = select(Entry.run_id).join(Run, Run.id == Entry.run_id)
        with self.backend.database.reading() as session:
            waiting = query.where(Run.state == RunState.QUEUED).order_by(Entry.run_id)
            return list(session.scalars(waiting))

    def finish(self, run_id: int, scores: Sequence[float], *, broken: int = 0) -> None:
        """Let a worker evaluate an entry; in the first `broken` trials it breaks a rule."""
        common: dict[str, Any] = {"level_held": 0.2, "overall": {}, "measures": {}, "levels": []}
        trials = [
            common | {"trial": at, "score": score, "rankable": at >= broken}
            for at, score in enumerate(scores)
        ]
        mean = sum(scores) / len(scores)
        metrics: dict[str, Any] = {"score": mean, "score_low": None, "score_high": None}
        metrics |= {"level_held": 0.2, "trials": trials, "not_ranked": "It hit the bottom."}
        assert self.backend.finish(self.claim(run_id), metrics=metrics)

    def fail(self, run_id: int, cause: FailureReason = FailureReason.USER_ERROR) -> None:
        report: dict[str, Any] = dict.fromkeys(("metrics", "manifest", "digest"))
        report |= {"state": RunState.FAILED, "cause": cause, "detail": {"title": "It failed."}}
        assert self.backend.finish(self.claim(run_id), **report)

    def claim(self, run_id: int) -> Claim:
        """Claim a run; those before it in the queue are left to others."""
        with self.backend.database.writing() as session:
            moved = (
                update(Run)
                .where(Run.id == run_id, Run.state == RunState.QUEUED)
                .values(state=RunState.RUNNING, attempt=Run.attempt + 1, started_at=time.time())
            )
            session.execute(moved)
            run = session.get_one(Run, run_id)
            return Claim.from_rows(
                run, run_id=run_id, worker="w1", lease_s=60.0, kind=run.kind, parts=()
            )

    def advance(self) -> int:
        """Do what maintenance does; return the number of runs that were queued."""
        with self.backend.database.writing() as session:
            return finals.advance(session, self.id, self.backend.settings)

    def board(self, number: int, *, by_method: bool = False) -> Board:
        view = self.view
        with self.backend.database.reading() as session:
            return boards.board(session, view, view.rounds[number - 1], by_method=by_method)

    def close_qualification(self) -> None:
        self.shift(PRACTICE, closes_in_s=0.0)
        self.shift(QUALIFICATION, closes_in_s=0.0)

    def begin_final(self) -> list[int]:
        """Close the qualification, begin the final, and return the runs of its first batch."""
        self.close_qualification()
        self.shift(FINAL, opens_in_s=-1.0)
        for _ in range(3):
            self.advance()
        return self.live()

    def play_batch(self, scores: Mapping[str, Sequence[float]], other: float = 10.0) -> None:
        """Evaluate what waits: methods have these scores, others the same one in all trials."""
        trials = self.asked.final.trials if self.asked.final else 0
        with self.backend.database.reading() as session:
            rows = [(run_id, session.get_one(Entry, run_id).method) for run_id in self.live()]
        for run_id, method in rows:
            self.finish(run_id, scores.get(method, [other + at for at in range(trials)]))


def _exactly(in_s: float) -> float:
    """Return a time not before that which both a double and a text of microseconds have."""
    return math.ceil((time.time() + in_s) / TICK_S) * TICK_S


def _text(in_s: float) -> str:
    return datetime.fromtimestamp(round(time.time() + in_s), UTC).isoformat()

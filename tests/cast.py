"""The people of the tests, and what they and their workers do with runs on a real database.

ann owns, eva shares what she made, ben must see nothing of ann's; tim teaches, olga organises,
root is the administrator;
a guest has only a cookie, and nobody not even that.
"""

import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from typing import Any, Self

from sqlalchemy import insert, or_, select

from seamark.programs import preparation
from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import Role, Viewer
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run, User
from seamark.server.programs import check_queue, own_files, store, vehicles
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.ending import first_results, results
from seamark.server.runs.ending.results import Report
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from seamark.server.runs.queue import queue as run_queue
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission import submission, validation
from seamark.server.settings import Settings
from seamark.sim.files import target_pictures
from seamark.sim.physics.water_motion import records
from seamark.sim.vehicles import own

USERS = ("ann", "eva", "ben")
STAFF = {"tim": Role.TEACHER, "olga": Role.ORGANISER, "root": Role.ADMIN}
CAST = dict.fromkeys(USERS, Role.USER) | STAFF
PROGRAM = b"""
class Controller:
    def __init__(self, config): ...
    def step(self, observation): ...
"""
VEHICLE = """
format = 1
name = "mine"
title = "Mine"
summary = "A BlueROV2 Heavy with a title of its own."
extends = "bluerov2-heavy-v2"

[defaults]
kp = 0.7
"""
RECORD = "# seamark-current 1\n# title: A test\ntime_s,height_m,north,east,down\n" + "".join(
    f"{10 * at},1,{0.2 + 0.02 * (at % 3)},0.05,0\n" for at in range(20)
)
# A picture for the target: stripes and a gradient, as binary PGM.
MARKER = b"P5\n500 160\n255\n" + bytes(
    (row + column // 3) % 200 + 50 * (column // 25 % 2)
    for row in range(160)
    for column in range(500)
)
PI_RUN: dict[str, Any] = {"benchmark": "currents-v1", "config": {}, "controller": "pi"}
MANIFEST = {"seed": 7, "trials": [{"seed": 9}]}


@dataclass
class Backend:
    """A database with the cast in it, and the steps of a run as the server's functions do them."""

    database: Database
    settings: Settings
    viewers: dict[str, Viewer]

    @classmethod
    def with_cast(cls, database: Database, settings: Settings) -> Self:
        """Sign up the people of the cast."""
        viewers = {"guest": Viewer(guest="g"), "nobody": Viewer()}
        rows = [row | {"created_at": time.time()} for row in _signed_up()]
        insertion = insert(User).returning(User.id, sort_by_parameter_order=True)
        with database.writing() as session:
            numbers = session.scalars(insertion, rows).all()
        for user_id, (name, role) in zip(numbers, CAST.items(), strict=True):
            viewers[name] = Viewer(user_id=user_id, name=name, account_role=role)
        return cls(database, settings, viewers)

    def sign_up(self, name: str, *, role: Role = Role.USER) -> Viewer:
        with self.database.writing() as session:
            user = accounts.sign_up(session, name, None, role=role)
        self.viewers[name] = Viewer(user_id=user.id, name=user.name, account_role=role)
        return self.viewers[name]

    def user_id(self, name: str) -> int:
        number = self.viewers[name].user_id
        assert number is not None
        return number

    def store_program(
        self, source: bytes = PROGRAM, name: str = "mine.py", role: str = "controller"
    ) -> StoredProgram:
        """Store a program as an upload of it is stored."""
        prepared = preparation.prepare(source, name, role=role)
        prepared.require_clean()
        return store.save(prepared, self.settings)

    def store_vehicle(self, text: str = VEHICLE) -> StoredVehicle:
        """Store the file of a vehicle as an upload of it is stored."""
        content = text.encode()
        return vehicles.save(own.usable(content).name, content, self.settings)

    def store_record(self, text: str = RECORD) -> StoredFile:
        """Store the file of a record of currents as an upload of it is stored."""
        return own_files.save(records.LIBRARY.setting, text.encode(), self.settings)

    def store_picture(self, content: bytes = MARKER) -> StoredFile:
        """Store a picture that covers the target as an upload of it is stored."""
        library = target_pictures.LIBRARY
        return own_files.save(library.setting, library.converted(content), self.settings)

    def unused_deleted(self) -> int:
        """Delete uploads that nothing refers to, however new they are; return how many."""
        with self.database.reading() as session:
            return store.delete_unused(
                self.settings,
                used=lambda sha256: check_queue.refers_to(session, sha256),
                older_than_s=-60.0,
            )

    def queue(self, who: str = "ann", *, kind: str = "practice", **changes: Any) -> int:
        """Queue a run of the built-in PI controller, or of what `changes` says."""
        wanted = PI_RUN | {"viewer": self.viewers[who], "kind": RunKind(kind)} | changes
        valid = validation.validate(validation.Submission(**wanted), self.settings)
        with self.database.writing() as session:
            return submission.submit(session, valid, self.settings)

    def queue_program(self, who: str = "ann", **changes: Any) -> int:
        """Queue a run of an uploaded program."""
        return self.queue(who, controller="upload", program=self.store_program(), **changes)

    def queue_vehicle(self, who: str = "ann", **changes: Any) -> int:
        """Queue a run with a vehicle of its user."""
        vehicle = self.store_vehicle()
        config = changes.pop("config", {}) | {"vehicle": vehicle.name}
        return self.queue(who, vehicle=vehicle, config=config, **changes)

    def rerun(self, run_id: int, who: str = "ann") -> int:
        with self.database.writing() as session:
            return submission.rerun(session, run_id, self.viewers[who], self.settings)

    def claim(self, worker: str = "w1", languages: tuple[str, ...] = ("python",)) -> Claim | None:
        return run_queue.claim(self.database, worker, languages=languages, settings=self.settings)

    def claim_next(self) -> Claim:
        """Claim the run that is first in the queue; there must be one."""
        claim = self.claim()
        assert claim is not None
        return claim

    def claim_alone(self, benchmark: str, controller: str) -> Claim:
        """Claim a queued run of this controller; the other queued runs are cancelled."""
        others = or_(Run.benchmark != benchmark, Run.controller != controller)
        with self.database.reading() as session:
            queued = select(Run.id).where(Run.state == RunState.QUEUED, others)
            cancelled = list(session.scalars(queued))
        for run_id in cancelled:
            assert self.cancel(run_id)
        return self.claim_next()

    def running(self, who: str = "ann", **changes: Any) -> Claim:
        """Queue a run and claim it; it must be the first in the queue."""
        run_id = self.queue(who, **changes)
        claim = self.claim_next()
        assert claim.run_id == run_id
        return claim

    def finish(self, claim: Claim, score: float = 50.0, **changes: Any) -> bool:
        """Report a success, or what `changes` says; False if the claim is no longer valid."""
        common: dict[str, Any] = {"level_held": 0.2, "overall": {}, "levels": []}
        trials = [common | {"trial": at, "score": score + at - 1.0} for at in range(3)]
        metrics: dict[str, Any] = {"score": score, "score_low": score - 5, "score_high": score + 5}
        metrics |= {"level_held": 0.2, "trials": trials}
        report: dict[str, Any] = {"metrics": metrics, "manifest": MANIFEST}
        report |= {"state": RunState.SUCCEEDED, "digest": "0" * 64, "t_simulated": 1800.0} | changes
        with self.database.writing() as session:
            if first_results.shows_fresh_trials(report.get("cause")):  # as the worker does
                first_results.record(session, claim.run_id, report["digest"])
            return results.finish(session, claim, Report(**report))

    def succeeded(self, who: str = "ann", **changes: Any) -> int:
        claim = self.running(who, **changes)
        assert self.finish(claim)
        return claim.run_id

    def failed(self, detail: Mapping[str, Any], who: str = "ann", **changes: Any) -> int:
        """Return a run whose program raised an error, described by `detail`."""
        claim = self.running(who, **changes)
        report: dict[str, Any] = dict.fromkeys(("metrics", "manifest", "digest"))
        report |= {"state": RunState.FAILED, "cause": "user_error", "detail": dict(detail)}
        assert self.finish(claim, **report)
        return claim.run_id

    def published(self, who: str = "eva", **changes: Any) -> int:
        return self.publish(self.succeeded(who, **changes))

    def publish(self, run_id: int, **terms: Any) -> int:
        run = self.show(run_id)
        terms.setdefault("method", run.title[:60] or ("Steady hand" if run.program_name else ""))
        with self.database.writing() as session:
            assert publications.publish(session, run_id, Terms(**terms))
        return run_id

    def cancel(self, run_id: int) -> bool:
        with self.database.writing() as session:
            return results.cancel(session, run_id) is not None

    def show(self, run_id: int) -> RunView:
        with self.database.reading() as session:
            view = views.show(session, run_id, self.settings)
        assert view is not None
        return view


@cache
def _signed_up() -> list[dict[str, Any]]:
    """Return what signing up the cast writes, found out once in a process."""
    table = User.metadata.tables[User.__tablename__]
    columns = [column for column in table.columns if not column.primary_key]
    with closing(Database("sqlite://")) as database:
        User.metadata.create_all(database.engine, [table])
        with database.writing() as session:
            for name, role in CAST.items():
                accounts.sign_up(session, name, None, role=role)
            return [dict(row) for row in session.execute(select(*columns)).mappings()]

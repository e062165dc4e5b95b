"""`./run chaos-backup [--runs N]`: a backup while many runs go on, restored elsewhere.

For SQLite and for PostgreSQL: a service with two workers evaluates N runs; when some of them have
ended it is backed up, and goes on to the end. The backup is restored elsewhere, with the other
database. There the runs that had ended must have the same rows, files and leaderboard, and the
others must get the result of an undisturbed run.
"""

import argparse
import ctypes
import os
import subprocess
import sys
import time
from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sqlalchemy import select

from seamark.embedded.supervisor import PR_SET_CHILD_SUBREAPER
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.database.tables import Result, Run
from seamark.server.messaging import broker
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import FINAL, RunState
from seamark.server.settings import Settings
from tests.cast import USERS, Backend
from tests.chaos.campaign import Campaign
from tests.chaos.installation import Installation
from tests.services import postgres
from tests.worker.conftest import Service, wait_until

RUNS, SEED = 100, 1
ENDED_FIRST = 0.2  # of the runs, before the backup
END_S = 3600.0
HEADER = "| database | to | runs | ended at the backup | went on | backup | restore | wrong |"


def evaluated(service: Service, runs: Mapping[int, str]) -> set[int]:
    """Return the runs that have ended."""
    query = select(Run.id).where(Run.id.in_(runs), Run.state.in_(FINAL))
    with service.database.reading() as session:
        return set(session.scalars(query))


def rows(database: Database, run_ids: set[int]) -> list[tuple[object, ...]]:
    """Return what the database has of runs that have ended, and of their results."""
    query = select(*Run.__table__.columns, *Result.__table__.columns).join(Result)
    with database.reading() as session:
        found = session.execute(query.where(Run.id.in_(run_ids)).order_by(Run.id))
        return [tuple(row) for row in found]


def sums(data: Path, run_ids: set[int]) -> dict[str, str]:
    """Return the SHA-256 of each file of runs."""
    folders = (RunFiles(data, run_id).folder for run_id in sorted(run_ids))
    files = (path for folder in folders for path in sorted(folder.iterdir()))
    return {str(path.relative_to(data)): sha256(path.read_bytes()).hexdigest() for path in files}


def leaderboard(settings: Settings) -> object:
    """Return the leaderboard as everybody reads it."""
    app = create_app(settings)
    answer = app.test_client().get("/api/v1/leaderboards/currents-v1")
    app.extensions["seamark"].close()
    return answer.get_json()


def seamark(settings: Settings, *arguments: str | Path) -> float:
    """Run a command of the operator; return how long it took [s]."""
    started_at = time.monotonic()
    command = [sys.executable, "-m", "seamark.cli.main", *map(str, arguments)]
    environment = os.environ | settings.environment()
    subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL)
    return time.monotonic() - started_at


class Trial:
    """One service that is backed up, and the one that is restored from it."""

    def __init__(self, folder: Path, server: postgres.Server, runs: int) -> None:
        self._folder, self._server, self._runs = folder, server, runs
        self._backup = folder / "backup.tar"
        self.wrong: list[str] = []
        self.cells: list[object] = []

    def run(self, source: str, target: str) -> None:
        """Back up from the database `source` and restore into `target`, given by their URLs."""
        with TemporaryDirectory(dir=self._folder) as first, TemporaryDirectory() as second:
            wanted, viewers = self._back_up(Path(first), source)
            self._restore(Path(second), target, wanted, viewers)

    def _back_up(self, folder: Path, url: str) -> tuple[Mapping[int, str], Any]:
        made = Installation(folder, self._server, url, warm_boxes=0)
        try:
            for who in USERS:
                made.service.published(who, kind="ranked")
            campaign = Campaign(made, self._runs, SEED)
            wanted, service = campaign.wanted, made.service
            wait_until(lambda: len(evaluated(service, wanted)) >= ENDED_FIRST * self._runs, END_S)
            self._before = evaluated(service, wanted)
            took_s = seamark(made.settings, "backup", self._backup)
            after = evaluated(service, wanted)
            self._board = leaderboard(made.settings)
            wait_until(lambda: len(evaluated(service, wanted)) == len(wanted), END_S)
            self._rows = rows(service.database, self._before)
            self._sums = sums(made.settings.data, self._before)
            self._look("source", service, wanted)
            going = len(wanted) - len(after)
            self.cells += [len(wanted), len(self._before), going, f"{took_s:.1f} s"]
            return wanted, service.viewers
        finally:
            made.stop()

    def _restore(self, folder: Path, url: str, wanted: Mapping[int, str], viewers: Any) -> None:
        settings = Settings.model_validate({"data": folder / "data", "database_url": url})
        self.cells.append(f"{seamark(settings, 'restore', self._backup):.1f} s")
        database = Database(url)
        if rows(database, self._before) != self._rows:
            self.wrong.append("rows differ")
        if sums(settings.data, self._before) != self._sums:
            self.wrong.append("files differ")
        database.close()

        def restored(its: Settings) -> Service:
            backend = Backend(Database(its.database_url), its, viewers)
            return Service(**vars(backend), redis=broker.connect(its))

        made = Installation(folder, self._server, url, service=restored, warm_boxes=0)
        try:
            if leaderboard(made.settings) != self._board:
                self.wrong.append("the leaderboard differs")
            wait_until(lambda: len(evaluated(made.service, wanted)) == len(wanted), END_S)
            self._look("restored", made.service, wanted)
        finally:
            made.stop()

    def _look(self, where: str, service: Service, wanted: Mapping[int, str]) -> None:
        for run_id, digest in wanted.items():
            view = service.show(run_id)
            if view.state is not RunState.SUCCEEDED or view.digest != digest:
                self.wrong.append(f"{where}: run {run_id}: {view.state} {view.cause}")


def main() -> int:
    """Run the session; return the exit code."""
    parser = argparse.ArgumentParser(prog="./run chaos-backup", description=__doc__)
    parser.add_argument("--runs", type=int, default=RUNS)
    options = parser.parse_args()
    # Processes that lose their parents become ours, so that they can be waited for.
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    print(HEADER, "|---" * 8 + "|", sep="\n", flush=True)
    problems: list[str] = []
    for kinds in (("SQLite", "PostgreSQL"), ("PostgreSQL", "SQLite")):
        with TemporaryDirectory(prefix="backup") as name, postgres.server() as server:
            with postgres.database(server.folder, "seamark") as url:
                urls = {"SQLite": f"sqlite:///{name}/seamark.db", "PostgreSQL": url}
                trial = Trial(Path(name), server, options.runs)
                trial.run(*(urls[kind] for kind in kinds))
        cells = [*kinds, *trial.cells, len(trial.wrong)]
        print(f"| {' | '.join(map(str, cells))} |", flush=True)
        problems += trial.wrong
    print(*problems, sep="\n")
    return int(bool(problems))


if __name__ == "__main__":
    sys.exit(main())

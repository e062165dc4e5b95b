"""Pages of a leaderboard of many people: `./run performance leaderboard [PEOPLE [URL]]`.

Fills an empty database (SQLite in a temporary folder, or that of the URL) and measures the wall
time of a page with its ranges of ranks. The baseline is one query that ranks all rows with a window
function, as a service without stored ranks would run it for every page.
"""

import statistics
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from sqlalchemy import select, text
from sqlalchemy.orm import Session

from performance.tables import Row
from performance.tables import text as text_of
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Best
from seamark.server.runs.leaderboard import leaderboard, leaderboard_filters, score_counts
from seamark.server.runs.leaderboard.board_rows import Cursor
from seamark.server.runs.leaderboard.leaderboard_filters import ONLY, BoardFilter
from seamark.server.runs.leaderboard.per import Per
from seamark.server.settings import Settings
from seamark.sim.numerics.ranking import Estimate, Population

PEOPLE = 1_000_000
NAME = "currents-v1"
REPEATS = 7
# Scores from 0 to 100 in no order, with standard errors from 0.05 to 0.25.
FILL = (
    """
    INSERT INTO users (id, name, name_key, role, is_baseline, created_at)
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < :people)
    SELECT i, 'u' || i, 'u' || i, 'user', FALSE, 1.0 FROM n
    """,
    """
    INSERT INTO runs (
        id, owner, user_id, benchmark, kind, config, trials, controller, title, notes, state,
        detail, queued_at, finished_at, attempt, failures, progress, t_simulated, public
    )
    SELECT
        id, 'user:' || id, id, :name, 'ranked', '{}', 10, 'pi', '', '', 'succeeded',
        '{}', 1.0, id, 1, 0, 1.0, 1.0, TRUE
    FROM users
    """,
    """
    INSERT INTO best (
        benchmark, user_id, run_id, score, score_low, score_high, standard_error, degrees,
        is_baseline, submissions, reached_at
    )
    SELECT
        :name, id, id, (id * 7919 % 1000003) / 10000.03, 0.0, 100.0,
        0.05 + (id * 104729 % 1009) / 5045.0, 9, FALSE, 1, id
    FROM users
    """,
    """
    INSERT INTO best_methods (
        benchmark, user_id, method, run_id, score, score_low, score_high, standard_error, degrees,
        is_baseline, submissions, reached_at
    )
    SELECT
        benchmark, user_id, 'pi', run_id, score, score_low, score_high, standard_error, degrees,
        is_baseline, submissions, reached_at
    FROM best
    """,
)
WINDOW = """
    SELECT * FROM (
        SELECT user_id, rank() OVER (ORDER BY score DESC) AS place FROM best
        WHERE benchmark = :name
    ) AS ranked WHERE place BETWEEN 501 AND 550
"""


def fill(database: Database, people: int) -> None:
    """Put many people on the leaderboard of `NAME`."""
    with database.writing() as session:
        for statement in FILL:
            session.execute(text(statement), {"people": people, "name": NAME})
        scores = session.execute(select(Best.score, Best.standard_error, Best.degrees))
        keys = (
            score_counts.key_of(Estimate(score=score, standard_error=error, degrees=degrees))
            for score, error, degrees in scores
        )
        score_counts.replace_all(session, Counter((NAME, key, per) for key in keys for per in Per))
    with database.engine.begin() as connection:
        connection.execute(text("ANALYZE"))


def wall_ms(call: Callable[[], object]) -> float:
    """Return the median wall time [ms] of some calls after a first one."""
    call()
    measured = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        call()
        measured.append(1e3 * (time.perf_counter() - start))
    return statistics.median(measured)


def measure(session: Session, people: int) -> list[Row]:
    """Return the wall times of pages and of a user's own rank, and the widths of ranges."""
    half = Cursor(50.0, 1.0, 1)
    calls: dict[str, Callable[[], object]] = {
        "first page of 50 rows": lambda: leaderboard.page(session, NAME),
        "page in the middle": lambda: leaderboard.page(session, NAME, after=half),
        "page with a filter that nobody passes": lambda: leaderboard_filters.page(
            session, NAME, BoardFilter(language="fmu"), after=half
        ),
        "first page of 50 methods": lambda: leaderboard.page(session, NAME, per=Per.METHOD),
        "page of methods in the middle": lambda: leaderboard.page(
            session, NAME, per=Per.METHOD, after=half
        ),
        "baselines": lambda: leaderboard_filters.page(session, NAME, BoardFilter(baselines=ONLY)),
        "own rank": lambda: leaderboard.rank_of(session, NAME, people // 2),
        "number of people": lambda: score_counts.size(session, NAME),
    }
    window = wall_ms(lambda: session.execute(text(WINDOW), {"name": NAME}).all())
    table = [
        Row(
            what=what,
            value=wall_ms(call),
            unit="ms",
            baseline="window function",
            baseline_value=window,
        )
        for what, call in calls.items()
    ]
    own = leaderboard.page(session, NAME, after=half, limit=1)[0]
    stored = session.get_one(Best, (NAME, own.user_id))
    exact = _exact(session).rank_range(
        Estimate(score=own.score, standard_error=stored.standard_error, degrees=stored.degrees)
    )
    width = float((own.rank_high or 0) - (own.rank_low or 0))
    table.append(
        Row(
            what="ranks in a range, by classes of scores",
            value=width,
            unit="",
            baseline="row by row",
            baseline_value=float(exact[1] - exact[0]),
        )
    )
    return table


def _exact(session: Session) -> Population:
    people = session.execute(select(Best.score, Best.standard_error, Best.degrees)).all()
    score, error, degrees = np.array([tuple(row) for row in people], dtype=float).T
    return Population(
        low=score,
        high=score,
        standard_error=error,
        degrees=degrees,
        counts=np.ones(len(score), dtype=np.int64),
    )


def rows(people: int = PEOPLE, url: str = "") -> list[Row]:
    """Fill a database and return the table."""
    with tempfile.TemporaryDirectory() as folder:
        url = url or f"sqlite:///{folder}/leaderboard.db"
        upgrade(Settings.model_validate({"data": Path(folder), "database_url": url}))
        database = Database(url)
        fill(database, people)
        with database.reading() as session:
            table = measure(session, people)
        database.close()
    return table


def main(arguments: Sequence[str]) -> int:
    """Measure with these arguments and print."""
    print(text_of(rows(int(arguments[0]), *arguments[1:])))
    return 0

"""`python -m performance.class_view [PUPILS [RUNS]]`: what a teacher's page of a large class costs.

Fills an empty SQLite database with a class and runs of each pupil for one assignment, and measures
the queries of the teacher's page, the ranking and the whole CSV. The baseline is the same page of a
class of 50 pupils with one run each.
"""

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from sqlalchemy import event, text
from sqlalchemy.orm import Session

from performance.table import Row, cpu_us
from performance.table import text as text_of
from seamark.server.classes import assignments, progress
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.settings import Settings
from seamark.server.web import assignment_csv

PUPILS, RUNS = 700, 20
CLASS = ASSIGNMENT = 1
FILL = (
    """
    INSERT INTO users (id, name, name_key, role, is_baseline, created_at)
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i <= :pupils)
    SELECT i, 'u' || i, 'u' || i, 'user', FALSE, 1.0 FROM n
    """,
    """
    INSERT INTO classes (id, teacher_id, name, code, created_at)
    SELECT 1, max(id), 'large', '0000000000', 1.0 FROM users
    """,
    """
    INSERT INTO memberships (class_id, user_id, joined_at)
    SELECT 1, id, 1.0 FROM users WHERE id <= :pupils
    """,
    """
    INSERT INTO assignments (
        id, class_id, title, instructions, benchmark, kind, config, trials, created_at
    )
    VALUES (1, 1, 'Hold', '', 'currents-v2', 'practice', '{}', 1, 1.0)
    """,
    """
    INSERT INTO runs (
        id, owner, user_id, benchmark, kind, config, seed, trials, controller, title, notes, state,
        detail, queued_at, finished_at, attempt, failures, progress, t_simulated, public
    )
    WITH RECURSIVE n(i) AS (SELECT 0 UNION ALL SELECT i + 1 FROM n WHERE i < :pupils * :runs - 1)
    SELECT
        i + 1, 'user:' || (i % :pupils + 1), i % :pupils + 1, 'currents-v2', 'practice', '{}', 7, 1,
        'pi', '', '', 'succeeded', '{}', 1.0, 2.0, 1, 0, 1.0, 1.0, FALSE
    FROM n
    """,
    """
    INSERT INTO results (run_id, attempt, score, rankable, metrics, created_at)
    SELECT id, 1, (id * 7919 % 10007) / 100.0, FALSE, '{"overall": {}}', 2.0 FROM runs
    """,
    """
    INSERT INTO assigned_runs (run_id, assignment_id, user_id, score)
    SELECT run_id, 1, user_id, score FROM results JOIN runs ON runs.id = run_id
    """,
    "ANALYZE",
)


def fill(database: Database, pupils: int, runs: int) -> None:
    """Make the class with its runs."""
    with database.writing() as session:
        for statement in FILL:
            session.execute(text(statement), {"pupils": pupils, "runs": runs})


def teachers_page(session: Session) -> None:
    """Read what the teacher's page of the assignment shows."""
    assignments.find(session, ASSIGNMENT)
    progress.page(session, CLASS, ASSIGNMENT)
    progress.totals(session, CLASS, ASSIGNMENT)
    progress.ranking(session, CLASS, ASSIGNMENT, None)


def queries(database: Database, call: Callable[[Session], None]) -> int:
    """Return how many statements a call sends."""
    sent: list[str] = []

    def count(*arguments: object) -> None:
        sent.append(str(arguments[2]))

    event.listen(database.engine, "before_cursor_execute", count)
    with database.reading() as session:
        call(session)
    event.remove(database.engine, "before_cursor_execute", count)
    return len(sent)


def measure(pupils: int, runs: int) -> tuple[int, float, float]:
    """Return the queries of the page, and the CPU time [us] of the page and of the CSV."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings.model_validate({"data": Path(folder)})
        upgrade(settings)
        database = Database(settings.database_url)
        fill(database, pupils, runs)

        def page() -> None:
            with database.reading() as session:
                teachers_page(session)

        def csv() -> None:
            with database.reading() as session:
                found = assignments.find(session, ASSIGNMENT)
            if found is None:
                raise LookupError("the assignment was not stored")
            for _ in assignment_csv.lines(database, found):
                pass

        count = queries(database, teachers_page)
        answer = count, cpu_us(page), cpu_us(csv, repeats=3)
        database.close()
    return answer


def main(pupils: int = PUPILS, runs: int = RUNS) -> None:
    """Measure and print."""
    small, large = measure(50, 1), measure(pupils, runs)
    of = f"{pupils} pupils with {runs} runs each"
    print(f"Statements of the teacher's page: {large[0]}, of a small class {small[0]}.")
    baseline = "50 pupils, 1 run each"
    rows = [
        Row(
            what=f"{what}, {of}",
            value=big / 1e3,
            unit="ms",
            baseline=baseline,
            baseline_value=few / 1e3,
        )
        for what, big, few in (("page", large[1], small[1]), ("CSV", large[2], small[2]))
    ]
    print(text_of(rows))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))

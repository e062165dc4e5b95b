"""What a teacher's page of a large class costs: `./run performance class_view [PUPILS [RUNS]]`.

Fills an empty SQLite database with a class and runs of each student for one assignment, and
measures the queries of the teacher's page, the ranking and the whole CSV. The baseline is the same
page of a class of 50 students with one run each.
"""

import tempfile
from collections.abc import Sequence
from pathlib import Path

from sqlalchemy import text
from sqlalchemy.orm import Session

from performance.service.database.queries import recorded
from performance.tables import Row, cpu_us
from performance.tables import text as text_of
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

        with recorded(database.engine) as asked:
            page()
        answer = asked.queries, cpu_us(page), cpu_us(csv, repeats=3)
        database.close()
    return answer


def rows(pupils: int = PUPILS, runs: int = RUNS) -> list[Row]:
    """Measure and return the rows."""
    large, small = measure(pupils, runs), measure(50, 1)
    of = f"{pupils} students with {runs} runs each"
    names = (("statements of the page", 1.0, ""), ("page", 1e3, "ms"), ("CSV", 1e3, "ms"))
    return [
        Row(
            what=f"{what}, {of}",
            value=big / scale,
            unit=unit,
            baseline="50 students, 1 run each",
            baseline_value=few / scale,
        )
        for (what, scale, unit), big, few in zip(names, large, small, strict=True)
    ]


def main(arguments: Sequence[str]) -> int:
    """Measure with these arguments and print."""
    print(text_of(rows(*map(int, arguments))))
    return 0

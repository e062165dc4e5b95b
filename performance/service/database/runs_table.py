"""A database with many runs, as a service has after years; made by bulk statements."""

import time

from sqlalchemy import text

from seamark.server.database import counters
from seamark.server.database.engine import Database
from seamark.server.runs.leaderboard import best_runs
from seamark.server.runs.record import totals, turns

RUNS_PER_OWNER = 100
# One run in a hundred failed, half are public, every tenth is ranked; the last ones are queued,
# each of another owner: that is the longest queue in turns.
_STATEMENTS = (
    """
    INSERT INTO users (id, name, name_key, role, is_baseline, created_at)
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < :owners)
    SELECT :first + i, 'many' || i, 'many' || i, 'user', FALSE, 1.0 FROM n
    """,
    """
    INSERT INTO runs (
        owner, user_id, benchmark, kind, config, seed, trials, controller, title, notes, state,
        cause, detail, queued_at, started_at, finished_at, attempt, failures, progress,
        t_simulated, public, published_at, expected_s
    )
    WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < :runs)
    SELECT
        'user:' || CAST(:first + 1 + i % :owners AS VARCHAR), :first + 1 + i % :owners,
        CASE WHEN i % 2 = 0 THEN 'currents-v2' ELSE 'visibility-v2' END,
        CASE WHEN i % 10 = 0 THEN 'ranked' ELSE 'practice' END,
        '{}', CASE WHEN i % 10 = 0 THEN NULL ELSE i END, 1, 'pi', '', '',
        CASE WHEN i > :ended THEN 'queued' WHEN i % 100 = 1 THEN 'failed' ELSE 'succeeded' END,
        CASE WHEN i <= :ended AND i % 100 = 1 THEN 'user_error' END,
        '{}', :now + i * 0.001, CASE WHEN i > :ended THEN NULL ELSE :now + i * 0.001 END,
        CASE WHEN i > :ended THEN NULL ELSE :now + 1.0 + i * 0.001 END, 1, 0, 0.0,
        600.0, i <= :ended AND i % 2 = 0, CASE WHEN i <= :ended AND i % 2 = 0 THEN :now END, 60.0
    FROM n
    """,
    """
    INSERT INTO results (run_id, attempt, score, score_low, score_high, rankable, created_at)
    SELECT id, 1, (id * 7919 % 1000003) / 10000.03, 0.0, 100.0, kind = 'ranked', 1.0
    FROM runs WHERE state = 'succeeded' AND user_id > :first
      AND id NOT IN (SELECT run_id FROM results)
    """,
)


def fill(database: Database, *, runs: int, queued: int) -> None:
    """Add `runs` runs, of which `queued` wait, and count them as the service does."""
    owners = max(runs // RUNS_PER_OWNER, queued, 1)
    with database.writing() as session:
        first = session.scalar(text("SELECT max(id) FROM users")) or 0
        values = {
            "runs": runs,
            "owners": owners,
            "first": first,
            "ended": runs - queued,
            "now": time.time() - 7 * 86_400.0,
        }
        for statement in _STATEMENTS:
            session.execute(text(statement), values)
        counters.store(session, totals.UNTIL, 0.0)
        totals.count_ended(session)
        turns.rebuild(session)
        best_runs.rebuild(session)
    with database.engine.begin() as connection:
        connection.execute(text("ANALYZE"))

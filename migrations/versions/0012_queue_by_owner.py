"""A row for each owner in the queue, counters of what ended, measured durations."""

import time

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"
branch_labels = None
depends_on = None

TURNS = ("priority", "queued", "running", "next_run", "expected_s")
ADD_MISSING_TURNS = """
    INSERT INTO turns (owner, served_at)
    SELECT DISTINCT owner, 0.0 FROM runs
    WHERE state IN ('queued', 'running') AND owner NOT IN (SELECT owner FROM turns)
"""
FILL_TURNS = """
    UPDATE turns SET
        priority = CASE
            WHEN owner IN (SELECT 'user:' || CAST(id AS VARCHAR) FROM users WHERE is_baseline) THEN 2
            WHEN owner LIKE 'guest:%' THEN 1
            ELSE 0
        END,
        queued = (SELECT count(*) FROM runs r WHERE r.owner = turns.owner AND r.state = 'queued'),
        running = (SELECT count(*) FROM runs r WHERE r.owner = turns.owner AND r.state = 'running'),
        next_run = (SELECT min(id) FROM runs r WHERE r.owner = turns.owner AND r.state = 'queued')
"""
COUNT_ENDED = """
    INSERT INTO counters (name, value)
    SELECT 'ended:' || state, count(*) FROM runs
    WHERE finished_at <= :until GROUP BY state
"""
COUNT_SIMULATED = """
    INSERT INTO counters (name, value)
    SELECT 'simulated_s', coalesce(sum(t_simulated), 0.0) FROM runs WHERE finished_at <= :until
"""
COUNTED_UNTIL = "INSERT INTO counters (name, value) VALUES ('counted_until', :until)"
LATE_S = 60.0  # transactions that are open meanwhile may store an earlier time


def upgrade() -> None:
    """Later changes of live runs keep the rows up to date; maintenance keeps the counters."""
    op.add_column("runs", sa.Column("expected_s", sa.Double(), nullable=True))
    _partial_index("ix_runs_queued_at", "runs", ["queued_at"], "state = 'queued'")
    _partial_index(
        "ix_runs_finished",
        "runs",
        ["finished_at", "state", "t_simulated"],
        "finished_at IS NOT NULL",
    )
    op.create_index("ix_runs_state_id", "runs", ["state", "id"])
    _extend_turns()
    op.create_table(
        "counters",
        sa.Column("name", sa.String(40), nullable=False),
        sa.Column("value", sa.Double(), nullable=False),
        sa.PrimaryKeyConstraint("name", name=op.f("pk_counters")),
    )
    op.create_table(
        "paces",
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("kind", sa.String(10), nullable=False),
        sa.Column("language", sa.String(40), nullable=False),
        sa.Column("wall_per_simulated", sa.Double(), nullable=False),
        sa.Column("runs", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("benchmark", "kind", "language", name=op.f("pk_paces")),
    )
    until = {"until": time.time() - LATE_S}
    for statement in (COUNT_ENDED, COUNT_SIMULATED, COUNTED_UNTIL):
        op.get_bind().execute(sa.text(statement), until)


def _extend_turns() -> None:
    for name in ("priority", "queued", "running"):
        op.add_column("turns", sa.Column(name, sa.Integer(), nullable=False, server_default="0"))
    op.add_column("turns", sa.Column("next_run", sa.BigInteger(), nullable=True))
    op.add_column(
        "turns", sa.Column("expected_s", sa.Double(), nullable=False, server_default="0")
    )
    op.execute(ADD_MISSING_TURNS)
    op.execute(FILL_TURNS)
    order = ["priority", "running", "served_at", "next_run"]
    _partial_index("ix_turns_next", "turns", order, "queued > 0")
    _partial_index("ix_turns_running", "turns", ["priority"], "running > 0")
    _partial_index("ix_turns_idle", "turns", ["served_at"], "queued = 0 AND running = 0")


def _partial_index(name: str, table: str, columns: list[str], condition: str) -> None:
    where = sa.text(condition)
    op.create_index(name, table, columns, sqlite_where=where, postgresql_where=where)


def downgrade() -> None:
    """The queue follows from the runs again."""
    op.drop_table("paces")
    op.drop_table("counters")
    for name in ("ix_turns_idle", "ix_turns_running", "ix_turns_next"):
        op.drop_index(name, "turns")
    for name in TURNS:
        op.drop_column("turns", name)
    for name in ("ix_runs_state_id", "ix_runs_finished", "ix_runs_queued_at"):
        op.drop_index(name, "runs")
    op.drop_column("runs", "expected_s")

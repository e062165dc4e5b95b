"""Runs that compute others again, and what became of their results."""

import sqlalchemy as sa
from alembic import op

revision = "0024"
down_revision = "0023"
branch_labels = None
depends_on = None

_ENDED = sa.text("finished_at IS NOT NULL")
_AGAIN = sa.text("rejudges IS NOT NULL")
_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """No run was computed again so far."""
    op.add_column("runs", sa.Column("rejudges", sa.BigInteger(), nullable=True))
    op.add_column("runs", sa.Column("data_run", sa.BigInteger(), nullable=True))
    _index_ended("finished_at", "state", "t_simulated", "rejudges")
    op.create_index("ix_runs_benchmark_finished", "runs", ["benchmark", "finished_at"])
    op.create_index(
        "ix_runs_rejudges", "runs", ["rejudges"], sqlite_where=_AGAIN, postgresql_where=_AGAIN
    )
    _create_rejudgements()
    _create_rejudged_runs()


def downgrade() -> None:
    """Accepted results stay; the earlier ones are lost, and so are the hidden runs."""
    op.drop_table("rejudged_runs")
    op.drop_table("rejudgements")
    op.drop_index("ix_runs_rejudges", "runs")
    op.drop_index("ix_runs_benchmark_finished", "runs")
    _index_ended("finished_at", "state", "t_simulated")
    hidden = "SELECT id FROM runs WHERE rejudges IS NOT NULL"
    op.execute(f"DELETE FROM results WHERE run_id IN ({hidden})")
    op.execute("DELETE FROM turns WHERE owner LIKE 'rejudgement:%'")
    op.execute("DELETE FROM runs WHERE rejudges IS NOT NULL")
    op.drop_column("runs", "data_run")
    op.drop_column("runs", "rejudges")


def _index_ended(*columns: str) -> None:
    op.drop_index("ix_runs_finished", "runs")
    op.create_index(
        "ix_runs_finished", "runs", list(columns), sqlite_where=_ENDED, postgresql_where=_ENDED
    )


def _create_rejudgements() -> None:
    op.create_table(
        "rejudgements",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("reason", sa.String(500), nullable=False),
        sa.Column("chosen", sa.JSON(), nullable=False),
        sa.Column("created_by", sa.String(80), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("decision", sa.String(10), nullable=True),
        sa.Column("decided_by", sa.String(80), nullable=True),
        sa.Column("decided_at", sa.Double(), nullable=True),
        sa.CheckConstraint(
            "decision IN ('accepted', 'discarded')", name=op.f("ck_rejudgements_decision")
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_rejudgements")),
        sqlite_autoincrement=True,
    )


def _create_rejudged_runs() -> None:
    op.create_table(
        "rejudged_runs",
        sa.Column("run_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("rejudgement_id", _ROW_ID, nullable=False),
        sa.Column("outcome", sa.String(10), nullable=True),
        sa.Column("before", sa.JSON(), nullable=True),
        sa.Column("after", sa.JSON(), nullable=True),
        sa.Column("metrics", sa.JSON(), nullable=True),
        sa.Column("metrics_count", sa.Integer(), nullable=False),
        sa.Column("replaced_at", sa.Double(), nullable=True),
        sa.Column("earlier", sa.JSON(), nullable=True),
        sa.CheckConstraint(
            "outcome IN ('same', 'different')", name=op.f("ck_rejudged_runs_outcome")
        ),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name=op.f("fk_rejudged_runs_run_id"), ondelete="CASCADE"
        ),
        sa.ForeignKeyConstraint(
            ["rejudgement_id"],
            ["rejudgements.id"],
            name=op.f("fk_rejudged_runs_rejudgement_id"),
            ondelete="CASCADE",
        ),
        sa.PrimaryKeyConstraint("run_id", name=op.f("pk_rejudged_runs")),
    )
    op.create_index(
        "ix_rejudged_runs_rejudgement_id_outcome",
        "rejudged_runs",
        ["rejudgement_id", "outcome", "run_id"],
    )

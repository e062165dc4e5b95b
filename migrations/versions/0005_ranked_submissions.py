"""Ranked submissions are counted and recognised; a result says why it does not rank."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None

# Ranked runs that ended, without failures of the platform and what never started.
_COUNT = """
    UPDATE best SET submissions = (
        SELECT count(*) FROM runs
        WHERE runs.kind = 'ranked'
        AND runs.user_id = best.user_id AND runs.benchmark = best.benchmark
        AND (
            runs.state = 'succeeded'
            OR (runs.state = 'failed' AND runs.cause <> 'platform_error')
            OR (runs.state = 'cancelled' AND runs.started_at IS NOT NULL)
        )
    )
"""


def upgrade() -> None:
    """Earlier runs are of benchmark versions without fresh trials: their column stays empty."""
    op.add_column("runs", sa.Column("submission", sa.String(64), nullable=True))
    op.add_column("results", sa.Column("not_ranked", sa.Text(), nullable=True))
    op.add_column(
        "best", sa.Column("submissions", sa.Integer(), nullable=False, server_default="1")
    )
    op.create_index(
        "ix_runs_user_benchmark_kind_queued", "runs", ["user_id", "benchmark", "kind", "queued_at"]
    )
    op.create_index(
        "ix_runs_submission",
        "runs",
        ["submission"],
        sqlite_where=sa.text("submission IS NOT NULL"),
        postgresql_where=sa.text("submission IS NOT NULL"),
    )
    op.execute(_COUNT)


def downgrade() -> None:
    """Drop the columns with their indexes."""
    op.drop_index("ix_runs_submission", table_name="runs")
    op.drop_index("ix_runs_user_benchmark_kind_queued", table_name="runs")
    op.drop_column("best", "submissions")
    op.drop_column("results", "not_ranked")
    op.drop_column("runs", "submission")

"""What was seen of fresh water outlives runs and accounts.

Revision ID: 0033
Revises: 0032
"""

import sqlalchemy as sa
from alembic import op

revision = "0033"
down_revision = "0032"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Keep the first run of each submission; until now, its data could be seen while it ran."""
    op.create_table(
        "seen_submissions",
        sa.Column("submission", sa.String(64), primary_key=True),
        sa.Column("run_id", sa.BigInteger, nullable=False),
        sa.Column("digest", sa.String(64)),
        sa.Column("seen_at", sa.Double, nullable=False),
    )
    op.execute(
        """
        INSERT INTO seen_submissions (submission, run_id, digest, seen_at)
        SELECT submission, id, digest, seen_at FROM (
            SELECT runs.submission, runs.id, results.digest,
                COALESCE(runs.finished_at, runs.queued_at) AS seen_at,
                ROW_NUMBER() OVER (
                    PARTITION BY runs.submission ORDER BY runs.started_at, runs.id
                ) AS place
            FROM runs LEFT JOIN results ON results.run_id = runs.id
            WHERE runs.kind = 'ranked' AND runs.rejudges IS NULL
                AND runs.submission IS NOT NULL AND runs.program_sha256 IS NOT NULL
                AND (runs.state = 'succeeded'
                    OR (runs.state = 'failed' AND runs.cause <> 'platform_error')
                    OR (runs.state = 'cancelled' AND runs.started_at IS NOT NULL))
        ) AS ended WHERE place = 1
        """
    )


def downgrade() -> None:
    """The rows of runs alone tell what was seen."""
    op.drop_table("seen_submissions")

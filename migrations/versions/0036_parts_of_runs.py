"""Runs with several programs: a table of those beside the one of the benchmark's role.

Revision ID: 0036
Revises: 0035
"""

import sqlalchemy as sa
from alembic import op

revision = "0036"
down_revision = "0035"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the table; no run has such programs yet."""
    op.create_table(
        "run_parts",
        sa.Column("run_id", sa.BigInteger().with_variant(sa.Integer(), "sqlite"), nullable=False),
        sa.Column("role", sa.String(20), nullable=False),
        sa.Column("program_sha256", sa.String(64), nullable=False),
        sa.Column("program_name", sa.String(255)),
        sa.Column("language", sa.String(40), nullable=False),
        sa.Column("program_parameters", sa.JSON),
        sa.PrimaryKeyConstraint("run_id", "role", name="pk_run_parts"),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_run_parts_run_id", ondelete="CASCADE"
        ),
    )
    op.create_index("ix_run_parts_program_sha256", "run_parts", ["program_sha256"])


def downgrade() -> None:
    """Forget which programs they were; runs with parts can no longer be evaluated."""
    op.drop_table("run_parts")

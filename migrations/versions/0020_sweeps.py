"""Sweeps: sets of runs that differ in one or two settings or parameters."""

import sqlalchemy as sa
from alembic import op

revision = "0020"
down_revision = "0019"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the table and the columns; earlier runs belong to no sweep."""
    row_id = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
    op.create_table(
        "sweeps",
        sa.Column("id", row_id, nullable=False),
        sa.Column("user_id", row_id, nullable=True),
        sa.Column("guest", sa.String(64), nullable=True),
        sa.Column("benchmark", sa.String(80), nullable=False),
        sa.Column("title", sa.String(120), nullable=False),
        sa.Column("axes", sa.JSON(), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name=op.f("fk_sweeps_user_id"), ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name=op.f("pk_sweeps")),
    )
    op.create_index(op.f("ix_sweeps_user_id"), "sweeps", ["user_id"])
    op.add_column("runs", sa.Column("sweep_id", sa.BigInteger(), nullable=True))
    op.add_column("runs", sa.Column("sweep_cell", sa.Integer(), nullable=True))
    in_sweep = sa.text("sweep_id IS NOT NULL")
    op.create_index(
        "ix_runs_sweep",
        "runs",
        ["sweep_id", "sweep_cell"],
        sqlite_where=in_sweep,
        postgresql_where=in_sweep,
    )


def downgrade() -> None:
    """Drop the columns and the table; the runs stay."""
    op.drop_index("ix_runs_sweep", "runs")
    op.drop_column("runs", "sweep_cell")
    op.drop_column("runs", "sweep_id")
    op.drop_index(op.f("ix_sweeps_user_id"), "sweeps")
    op.drop_table("sweeps")

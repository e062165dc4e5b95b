"""An index for quotas and for lists of a user's runs by state: a user may have thousands of runs."""

from alembic import op

revision = "0003"
down_revision = "0002"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the index."""
    op.create_index(
        "ix_runs_owner_state_finished", "runs", ["owner", "state", "finished_at"], unique=False
    )


def downgrade() -> None:
    """Drop the index."""
    op.drop_index("ix_runs_owner_state_finished", table_name="runs")

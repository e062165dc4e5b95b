"""An index for the quota and for one's own runs of one state: people may have many thousands."""

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
    """Drop it."""
    op.drop_index("ix_runs_owner_state_finished", table_name="runs")

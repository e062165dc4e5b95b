"""The published runs of a user, newest first."""

from alembic import op

revision = "0018"
down_revision = "0017"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Create the index that the page of a user reads."""
    op.create_index("ix_runs_owner_public_id", "runs", ["owner", "public", "id"])


def downgrade() -> None:
    """Drop the index."""
    op.drop_index("ix_runs_owner_public_id", "runs")

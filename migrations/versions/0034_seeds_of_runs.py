"""Workers are given the seeds of a run instead of the key that derives all seeds.

Revision ID: 0034
Revises: 0033
"""

import sqlalchemy as sa
from alembic import op

revision = "0034"
down_revision = "0033"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Add the seeds; whoever has the key fills in those of runs that wait."""
    op.add_column("runs", sa.Column("trial_seeds", sa.JSON))


def downgrade() -> None:
    """Workers need the key again."""
    op.drop_column("runs", "trial_seeds")

"""Workers report what they would compute: outdated ones count in no estimate.

Revision ID: 0030
Revises: 0029
"""

import sqlalchemy as sa
from alembic import op

revision = "0030"
down_revision = "0029"
branch_labels = None
depends_on = None


def upgrade() -> None:
    """Workers of earlier versions do not report it."""
    op.add_column("workers", sa.Column("result_code", sa.Text(), nullable=True))


def downgrade() -> None:
    """It is reported again at the next start."""
    op.drop_column("workers", "result_code")

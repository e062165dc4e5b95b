"""The id of the request that queued a run.

Revision ID: 0025
Revises: 0024
"""

import sqlalchemy as sa
from alembic import op

revision = "0025"
down_revision = "0024"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("runs", sa.Column("request_id", sa.String(64)))


def downgrade() -> None:
    op.drop_column("runs", "request_id")

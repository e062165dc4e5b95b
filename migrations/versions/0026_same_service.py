"""By which each machine proves that it belongs to the service: its seeds and its code.

Revision ID: 0026
Revises: 0025
"""

import sqlalchemy as sa
from alembic import op

revision = "0026"
down_revision = "0025"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.add_column("data_folder", sa.Column("seed_proof", sa.String(64)))
    op.add_column("data_folder", sa.Column("result_code", sa.Text))


def downgrade() -> None:
    op.drop_column("data_folder", "result_code")
    op.drop_column("data_folder", "seed_proof")

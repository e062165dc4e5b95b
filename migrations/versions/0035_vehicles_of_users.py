"""Runs and checks with a vehicle that their user has uploaded.

Revision ID: 0035
Revises: 0034
"""

import sqlalchemy as sa
from alembic import op

revision = "0035"
down_revision = "0034"
branch_labels = None
depends_on = None

_UPLOADED = sa.text("vehicle_sha256 IS NOT NULL")


def upgrade() -> None:
    """Add the SHA-256 of the vehicle's file, which is stored as programs are."""
    for table in ("runs", "checks"):
        op.add_column(table, sa.Column("vehicle_sha256", sa.String(64)))
    op.create_index(
        "ix_runs_vehicle_sha256",
        "runs",
        ["vehicle_sha256"],
        sqlite_where=_UPLOADED,
        postgresql_where=_UPLOADED,
    )


def downgrade() -> None:
    """Forget which file it was; runs with such a vehicle can no longer be evaluated."""
    op.drop_index("ix_runs_vehicle_sha256", "runs")
    for table in ("runs", "checks"):
        op.drop_column(table, "vehicle_sha256")

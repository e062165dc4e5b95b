"""E-mail: addresses of accounts, what is to be sent, runs to tell about.

Revision ID: 0028
Revises: 0027
"""

import sqlalchemy as sa
from alembic import op

revision = "0028"
down_revision = "0027"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")
_UNSENT = sa.text("ended_at IS NULL")


def upgrade() -> None:
    """Nobody has an address, and nobody gets e-mail."""
    op.add_column("users", sa.Column("notify_minutes", sa.Integer(), nullable=True))
    op.create_table(
        "mail_addresses",
        sa.Column("user_id", _ROW_ID, autoincrement=False, nullable=False),
        sa.Column("address", sa.String(254), nullable=True),
        sa.Column("address_hash", sa.String(64), nullable=True),
        sa.Column("pending", sa.String(254), nullable=True),
        sa.Column("pending_hash", sa.String(64), nullable=True),
        sa.Column("pending_until", sa.Double(), nullable=True),
        _of_user("mail_addresses"),
        sa.PrimaryKeyConstraint("user_id", name="pk_mail_addresses"),
        sa.UniqueConstraint("pending_hash", name="uq_mail_addresses_pending_hash"),
    )
    op.create_index("ix_mail_addresses_address_hash", "mail_addresses", ["address_hash"])
    op.create_table(
        "outgoing_mails",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("kind", sa.String(20), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=True),
        sa.Column("address_hash", sa.String(64), nullable=False),
        sa.Column("created_at", sa.Double(), nullable=False),
        sa.Column("next_try_at", sa.Double(), nullable=False),
        sa.Column("tries", sa.Integer(), nullable=False),
        sa.Column("ended_at", sa.Double(), nullable=True),
        _of_user("outgoing_mails", "SET NULL"),
        sa.PrimaryKeyConstraint("id", name="pk_outgoing_mails"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_outgoing_mails_user_id", "outgoing_mails", ["user_id"])
    op.create_index(
        "ix_outgoing_mails_address_hash_created", "outgoing_mails", ["address_hash", "created_at"]
    )
    op.create_index(
        "ix_outgoing_mails_due",
        "outgoing_mails",
        ["next_try_at"],
        sqlite_where=_UNSENT,
        postgresql_where=_UNSENT,
    )
    op.create_table(
        "run_notices",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("run_id", _ROW_ID, nullable=False),
        _of_user("run_notices"),
        sa.ForeignKeyConstraint(
            ["run_id"], ["runs.id"], name="fk_run_notices_run_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_run_notices"),
        sqlite_autoincrement=True,
    )
    op.create_index("ix_run_notices_user_id", "run_notices", ["user_id"])
    op.create_index("ix_run_notices_run_id", "run_notices", ["run_id"])


def downgrade() -> None:
    """All addresses are lost, and what has not been sent."""
    for table in ("run_notices", "outgoing_mails", "mail_addresses"):
        op.drop_table(table)
    op.drop_column("users", "notify_minutes")


def _of_user(table: str, then: str = "CASCADE") -> sa.ForeignKeyConstraint:
    return sa.ForeignKeyConstraint(
        ["user_id"], ["users.id"], name=f"fk_{table}_user_id", ondelete=then
    )

"""Links for new passwords, and accounts whose runs are being deleted."""

import sqlalchemy as sa
from alembic import op

revision = "0019"
down_revision = "0018"
branch_labels = None
depends_on = None

_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def _user(table: str) -> sa.ForeignKeyConstraint:
    name = op.f(f"fk_{table}_user_id_users")
    return sa.ForeignKeyConstraint(["user_id"], ["users.id"], name=name, ondelete="CASCADE")


def upgrade() -> None:
    """Create both tables."""
    op.create_table(
        "password_resets",
        sa.Column("hash", sa.String(64), nullable=False),
        sa.Column("user_id", _ID, nullable=False),
        sa.Column("expires_at", sa.Double(), nullable=False),
        _user("password_resets"),
        sa.PrimaryKeyConstraint("hash", name=op.f("pk_password_resets")),
    )
    op.create_index("ix_password_resets_user_id", "password_resets", ["user_id"])
    op.create_table(
        "account_deletions",
        sa.Column("user_id", _ID, nullable=False),
        sa.Column("requested_at", sa.Double(), nullable=False),
        _user("account_deletions"),
        sa.PrimaryKeyConstraint("user_id", name=op.f("pk_account_deletions")),
    )


def downgrade() -> None:
    """Drop both; an account that was closed stays closed."""
    op.drop_table("account_deletions")
    op.drop_table("password_resets")

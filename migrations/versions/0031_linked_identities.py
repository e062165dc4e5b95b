"""Identities of an identity provider that are linked to accounts.

Revision ID: 0031
Revises: 0030
"""

import sqlalchemy as sa
from alembic import op

revision = "0031"
down_revision = "0030"
branch_labels = None
depends_on = None

_ROW_ID = sa.BigInteger().with_variant(sa.Integer(), "sqlite")


def upgrade() -> None:
    """No identity is linked to any account."""
    op.create_table(
        "linked_identities",
        sa.Column("id", _ROW_ID, nullable=False),
        sa.Column("issuer", sa.String(300), nullable=False),
        sa.Column("subject", sa.String(255), nullable=False),
        sa.Column("user_id", _ROW_ID, nullable=False),
        sa.Column("label", sa.String(120), nullable=False),
        sa.Column("linked_at", sa.Double(), nullable=False),
        sa.ForeignKeyConstraint(
            ["user_id"], ["users.id"], name="fk_linked_identities_user_id", ondelete="CASCADE"
        ),
        sa.PrimaryKeyConstraint("id", name="pk_linked_identities"),
        sa.UniqueConstraint("issuer", "subject", name="uq_linked_identities_issuer_subject"),
        sa.UniqueConstraint("user_id", "issuer", name="uq_linked_identities_user_id_issuer"),
    )


def downgrade() -> None:
    """Accounts without a password need a link for one."""
    op.drop_table("linked_identities")

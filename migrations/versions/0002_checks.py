"""Checks of programs before submission; an index to find the runs that use a program."""

import sqlalchemy as sa
from alembic import op

revision = '0002'
down_revision = '0001'
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table('checks',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('user_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('benchmark', sa.String(length=80), nullable=False),
    sa.Column('config', sa.JSON(), nullable=False),
    sa.Column('program_sha256', sa.String(length=64), nullable=False),
    sa.Column('program_name', sa.String(length=255), nullable=False),
    sa.Column('language', sa.String(length=40), nullable=False),
    sa.Column('state', sa.String(length=10), nullable=False),
    sa.Column('queued_at', sa.Double(), nullable=False),
    sa.Column('finished_at', sa.Double(), nullable=True),
    sa.Column('attempt', sa.Integer(), nullable=False),
    sa.Column('lease_until', sa.Double(), nullable=True),
    sa.Column('answer', sa.JSON(), nullable=True),
    sa.CheckConstraint("state IN ('queued', 'running', 'done')", name=op.f('ck_checks_state')),
    sa.CheckConstraint("(state = 'done') = (answer IS NOT NULL)", name=op.f('ck_checks_answer')),
    sa.ForeignKeyConstraint(['user_id'], ['users.id'], name=op.f('fk_checks_user_id_users'), ondelete='CASCADE'),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_checks')),
    sqlite_autoincrement=True,
    )
    op.create_index('ix_checks_user_id', 'checks', ['user_id'], unique=False)
    op.create_index('ix_checks_state_id', 'checks', ['state', 'id'], unique=False)
    op.create_index('ix_runs_program_sha256', 'runs', ['program_sha256'], unique=False)


def downgrade() -> None:
    op.drop_index('ix_runs_program_sha256', 'runs')
    op.drop_table('checks')

"""First schema: accounts, runs, results, ranks, workers."""

import sqlalchemy as sa
from alembic import op

revision = '0001'
down_revision = None
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table('turns',
    sa.Column('owner', sa.String(length=80), nullable=False),
    sa.Column('served_at', sa.Double(), nullable=False),
    sa.PrimaryKeyConstraint('owner', name=op.f('pk_turns'))
    )
    op.create_table('users',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('name', sa.String(length=40), nullable=False),
    sa.Column('name_key', sa.String(length=80), nullable=False),
    sa.Column('password_hash', sa.Text(), nullable=True),
    sa.Column('is_admin', sa.Boolean(), nullable=False),
    sa.Column('is_baseline', sa.Boolean(), nullable=False),
    sa.Column('created_at', sa.Double(), nullable=False),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_users')),
    sa.UniqueConstraint('name_key', name=op.f('uq_users_name_key'))
    )
    op.create_table('workers',
    sa.Column('name', sa.String(length=255), nullable=False),
    sa.Column('slots', sa.Integer(), nullable=False),
    sa.Column('level', sa.String(length=10), nullable=False),
    sa.Column('languages', sa.JSON(), nullable=False),
    sa.Column('findings', sa.JSON(), nullable=False),
    sa.Column('started_at', sa.Double(), nullable=False),
    sa.Column('seen_at', sa.Double(), nullable=False),
    sa.PrimaryKeyConstraint('name', name=op.f('pk_workers'))
    )
    op.create_table('runs',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('owner', sa.String(length=80), nullable=False),
    sa.Column('user_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=True),
    sa.Column('guest', sa.String(length=64), nullable=True),
    sa.Column('benchmark', sa.String(length=80), nullable=False),
    sa.Column('kind', sa.String(length=10), nullable=False),
    sa.Column('config', sa.JSON(), nullable=False),
    sa.Column('seed', sa.BigInteger(), nullable=True),
    sa.Column('trials', sa.Integer(), nullable=False),
    sa.Column('controller', sa.String(length=80), nullable=False),
    sa.Column('program_sha256', sa.String(length=64), nullable=True),
    sa.Column('program_name', sa.String(length=255), nullable=True),
    sa.Column('language', sa.String(length=40), nullable=True),
    sa.Column('title', sa.String(length=120), nullable=False),
    sa.Column('notes', sa.Text(), nullable=False),
    sa.Column('rerun_of', sa.BigInteger(), nullable=True),
    sa.Column('state', sa.String(length=10), nullable=False),
    sa.Column('cause', sa.String(length=20), nullable=True),
    sa.Column('detail', sa.JSON(), nullable=False),
    sa.Column('queued_at', sa.Double(), nullable=False),
    sa.Column('started_at', sa.Double(), nullable=True),
    sa.Column('finished_at', sa.Double(), nullable=True),
    sa.Column('attempt', sa.Integer(), nullable=False),
    sa.Column('failures', sa.Integer(), nullable=False),
    sa.Column('worker', sa.String(length=255), nullable=True),
    sa.Column('lease_until', sa.Double(), nullable=True),
    sa.Column('cancel_requested', sa.Boolean(), nullable=False),
    sa.Column('progress', sa.Double(), nullable=False),
    sa.Column('t_simulated', sa.Double(), nullable=False),
    sa.Column('isolation', sa.String(length=10), nullable=True),
    sa.Column('public', sa.Boolean(), nullable=False),
    sa.Column('published_at', sa.Double(), nullable=True),
    sa.CheckConstraint("(kind = 'ranked') = (seed IS NULL)", name=op.f('ck_runs_hidden_seed')),
    sa.CheckConstraint("(state = 'failed') = (cause IS NOT NULL)", name=op.f('ck_runs_cause')),
    sa.CheckConstraint("state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')", name=op.f('ck_runs_state')),
    sa.ForeignKeyConstraint(['user_id'], ['users.id'], name=op.f('fk_runs_user_id')),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_runs'))
    )
    with op.batch_alter_table('runs', schema=None) as batch_op:
        batch_op.create_index('ix_runs_benchmark_state_id', ['benchmark', 'state', 'id'], unique=False)
        batch_op.create_index('ix_runs_owner_id', ['owner', 'id'], unique=False)
        batch_op.create_index('ix_runs_public_id', ['public', 'id'], unique=False)
        batch_op.create_index('ix_runs_queued', ['owner', 'id', 'language'], unique=False, sqlite_where=sa.text("state = 'queued'"), postgresql_where=sa.text("state = 'queued'"))
        batch_op.create_index('ix_runs_running', ['owner'], unique=False, sqlite_where=sa.text("state = 'running'"), postgresql_where=sa.text("state = 'running'"))

    op.create_table('tokens',
    sa.Column('id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('user_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('name', sa.String(length=80), nullable=False),
    sa.Column('hash', sa.String(length=64), nullable=False),
    sa.Column('scopes', sa.JSON(), nullable=False),
    sa.Column('created_at', sa.Double(), nullable=False),
    sa.Column('expires_at', sa.Double(), nullable=True),
    sa.Column('last_used_at', sa.Double(), nullable=True),
    sa.ForeignKeyConstraint(['user_id'], ['users.id'], name=op.f('fk_tokens_user_id'), ondelete='CASCADE'),
    sa.PrimaryKeyConstraint('id', name=op.f('pk_tokens')),
    sa.UniqueConstraint('hash', name=op.f('uq_tokens_hash'))
    )
    with op.batch_alter_table('tokens', schema=None) as batch_op:
        batch_op.create_index(batch_op.f('ix_tokens_user_id'), ['user_id'], unique=False)

    op.create_table('best',
    sa.Column('benchmark', sa.String(length=80), nullable=False),
    sa.Column('user_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), autoincrement=False, nullable=False),
    sa.Column('run_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), nullable=False),
    sa.Column('score', sa.Double(), nullable=False),
    sa.Column('score_low', sa.Double(), nullable=False),
    sa.Column('score_high', sa.Double(), nullable=False),
    sa.Column('level_held', sa.Double(), nullable=True),
    sa.Column('reached_at', sa.Double(), nullable=False),
    sa.CheckConstraint('score > -1e300 AND score < 1e300', name=op.f('ck_best_finite')),
    sa.ForeignKeyConstraint(['run_id'], ['runs.id'], name=op.f('fk_best_run_id'), ondelete='CASCADE'),
    sa.ForeignKeyConstraint(['user_id'], ['users.id'], name=op.f('fk_best_user_id'), ondelete='CASCADE'),
    sa.PrimaryKeyConstraint('benchmark', 'user_id', name=op.f('pk_best')),
    sa.UniqueConstraint('run_id', name=op.f('uq_best_run_id'))
    )
    # Alembic cannot reflect an index with an expression from SQLite, so it does not generate it.
    op.create_index('ix_best_rank', 'best', ['benchmark', sa.text('score DESC'), 'reached_at', 'user_id'])
    op.create_table('results',
    sa.Column('run_id', sa.BigInteger().with_variant(sa.Integer(), 'sqlite'), autoincrement=False, nullable=False),
    sa.Column('attempt', sa.Integer(), nullable=False),
    sa.Column('digest', sa.String(length=64), nullable=True),
    sa.Column('score', sa.Double(), nullable=True),
    sa.Column('score_low', sa.Double(), nullable=True),
    sa.Column('score_high', sa.Double(), nullable=True),
    sa.Column('level_held', sa.Double(), nullable=True),
    sa.Column('rankable', sa.Boolean(), nullable=False),
    sa.Column('metrics', sa.JSON(), nullable=True),
    sa.Column('manifest', sa.JSON(), nullable=True),
    sa.Column('created_at', sa.Double(), nullable=False),
    sa.CheckConstraint('score IS NULL OR (score > -1e300 AND score < 1e300)', name=op.f('ck_results_finite')),
    sa.ForeignKeyConstraint(['run_id'], ['runs.id'], name=op.f('fk_results_run_id'), ondelete='CASCADE'),
    sa.PrimaryKeyConstraint('run_id', name=op.f('pk_results'))
    )


def downgrade() -> None:
    op.drop_table('results')
    op.drop_table('best')
    with op.batch_alter_table('tokens', schema=None) as batch_op:
        batch_op.drop_index(batch_op.f('ix_tokens_user_id'))

    op.drop_table('tokens')
    with op.batch_alter_table('runs', schema=None) as batch_op:
        batch_op.drop_index('ix_runs_running', sqlite_where=sa.text("state = 'running'"), postgresql_where=sa.text("state = 'running'"))
        batch_op.drop_index('ix_runs_queued', sqlite_where=sa.text("state = 'queued'"), postgresql_where=sa.text("state = 'queued'"))
        batch_op.drop_index('ix_runs_public_id')
        batch_op.drop_index('ix_runs_owner_id')
        batch_op.drop_index('ix_runs_benchmark_state_id')

    op.drop_table('runs')
    op.drop_table('workers')
    op.drop_table('users')
    op.drop_table('turns')

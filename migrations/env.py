"""Run by Alembic for each command; configured in server/database/schema.py."""

from alembic import context

from seamark.server.database.schema import run_environment


def _run() -> None:
    with context.begin_transaction():
        context.run_migrations()


run_environment(context.config.attributes, context.configure, _run)

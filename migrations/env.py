"""Called by Alembic for each command; all choices are in server/migrate.py."""

from alembic import context

from server.migrate import run_environment


def _run() -> None:
    with context.begin_transaction():
        context.run_migrations()


run_environment(context.config.attributes, context.configure, _run)

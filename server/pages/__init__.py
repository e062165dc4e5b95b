"""The pages: one blueprint per page. Adding a page is one file here and one line in `PAGES`."""

from flask import Flask

from seamark.server.pages import (
    account,
    benchmarks,
    docs,
    errors,
    formats,
    home,
    leaderboard,
    row_numbers,
    run,
    runs,
    status,
    submit,
)

PAGES = (
    home.page,
    submit.page,
    benchmarks.page,
    run.page,
    runs.page,
    leaderboard.page,
    account.page,
    docs.page,
    status.page,
)


def register(app: Flask) -> None:
    """Add all pages, the filters of their templates and the pages of errors."""
    row_numbers.register(app)
    for page in PAGES:
        app.register_blueprint(page)
    formats.register(app)
    errors.register(app)

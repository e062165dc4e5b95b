"""The pages: one blueprint per page. Adding a page is one file here and one line in `PAGES`."""

from flask import Flask

from seamark.server.pages import errors
from seamark.server.pages.account import account, identity, invitations, mail, own_account, profile
from seamark.server.pages.administration import ADMIN_PAGES
from seamark.server.pages.benchmark import benchmarks
from seamark.server.pages.classes import assignments, classes
from seamark.server.pages.compare import compare
from seamark.server.pages.competitions import competitions, organising, results, teams
from seamark.server.pages.docs import docs, download, guides
from seamark.server.pages.docs.articles import article, code_block, with_way_to_install
from seamark.server.pages.home import demo, home, status
from seamark.server.pages.leaderboard import leaderboard
from seamark.server.pages.previews import link_preview_pictures
from seamark.server.pages.publication import publications
from seamark.server.pages.run import mission_logs, run, runs, sparkline
from seamark.server.pages.submission import first_program, submit
from seamark.server.pages.sweep import sweep
from seamark.server.web import template_filters, url_converters

PAGES = (
    home.page,
    demo.page,
    submit.page,
    first_program.page,
    benchmarks.page,
    run.page,
    publications.page,
    runs.page,
    mission_logs.page,
    sweep.page,
    compare.page,
    leaderboard.page,
    link_preview_pictures.page,
    profile.page,
    account.page,
    own_account.page,
    mail.page,
    identity.page,
    invitations.page,
    classes.page,
    assignments.page,
    competitions.page,
    results.page,
    teams.page,
    organising.page,
    docs.page,
    download.page,
    status.page,
)


def register(app: Flask) -> None:
    """Add all pages, the filters of their templates and the pages of errors."""
    url_converters.register(app)
    for page in (*PAGES, *(one.blueprint for one in ADMIN_PAGES)):
        app.register_blueprint(page)
    app.jinja_env.globals["admin_pages"] = ADMIN_PAGES
    template_filters.register(app)
    app.add_template_filter(article)
    app.add_template_filter(with_way_to_install)
    app.add_template_filter(code_block, "code")
    app.add_template_filter(guides.markdown)
    app.add_template_filter(sparkline.segments)
    errors.register(app)

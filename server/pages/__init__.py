"""The pages: one blueprint per page. Adding a page is one file here and one line in `PAGES`."""

from flask import Flask

from seamark.server.pages import (
    account,
    administration,
    assignments,
    audit_log,
    benchmarks,
    classes,
    compare,
    demo,
    docs,
    download,
    errors,
    first_program,
    guides,
    home,
    identity,
    invitations,
    leaderboard,
    link_preview_pictures,
    mail,
    mission_logs,
    own_account,
    people,
    profile,
    publications,
    rejudgements,
    run,
    runs,
    sparkline,
    status,
    submit,
    sweep,
)
from seamark.server.pages.code_blocks import code_block
from seamark.server.pages.docs_articles import article, with_way_to_install
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
    docs.page,
    download.page,
    status.page,
    administration.page,
    people.page,
    rejudgements.page,
    audit_log.page,
)


def register(app: Flask) -> None:
    """Add all pages, the filters of their templates and the pages of errors."""
    url_converters.register(app)
    for page in PAGES:
        app.register_blueprint(page)
    template_filters.register(app)
    app.add_template_filter(article)
    app.add_template_filter(with_way_to_install)
    app.add_template_filter(code_block, "code")
    app.add_template_filter(guides.markdown)
    app.add_template_filter(sparkline.segments)
    errors.register(app)

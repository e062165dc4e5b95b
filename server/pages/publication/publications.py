"""Publishing a run on chosen terms, and the address under which it is found for ever."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime

from flask import Blueprint, flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.programs.licences import LICENCES, NONE
from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.publication import citations, publications
from seamark.server.runs.publication.publications import PublicationRefused, Terms
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.recomputation.verifications import VerificationRefused, VerificationView
from seamark.server.runs.record import method_names
from seamark.server.runs.record.method_names import METHOD_MAX
from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, known_benchmarks, publication
from seamark.server.web.citation import citation_of
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address

_NOT_PUBLISHABLE = "Only a finished run that has its data can be published."
page = Blueprint("publications", __name__)


@page.get("/p/<row:run_id>")
def permanent(run_id: int) -> ResponseReturnValue:
    """Lead to a published run; say of a withdrawn one that it was there."""
    with services().database.reading() as session:
        history = publications.history(session, run_id)
        run = views.show(session, run_id)
    if history is None or (run is None and history.withdrawn_at is None):
        raise Problem("not-found")
    if history.withdrawn_at is None:
        return redirect(url_for("run.show", run_id=run_id))
    days = (_day(history.first_at), _day(history.withdrawn_at))
    page = render_template("publications/withdrawn.html", run_id=run_id, days=days)
    return page, 410


@page.get("/runs/<row:run_id>/publish")
def form(run_id: int) -> ResponseReturnValue:
    """Show on which terms the run can be published."""
    run = access.run_for(run_id, Action.PUBLISH)
    if run.public or not run.state.final or run.data_deleted_at is not None:
        return _back(run_id, "The run is already public." if run.public else _NOT_PUBLISHABLE)
    return _form(run, Terms(method=_suggested(run)), "")


@page.post("/runs/<row:run_id>/publish")
def publish(run_id: int) -> ResponseReturnValue:
    """Make a run public, or show the form again with the reason why not."""
    run = access.run_for(run_id, Action.PUBLISH)
    terms = _terms()
    try:
        with services().database.writing() as session:
            changed = publication.publish(session, run_id, terms)
    except PublicationRefused as refusal:
        return _form(run, terms, str(refusal)), 422
    return _back(run_id, "" if changed else _NOT_PUBLISHABLE, _done(run, terms))


@page.post("/runs/<row:run_id>/reveal")
def reveal(run_id: int) -> ResponseReturnValue:
    """Show who made an anonymous run."""
    access.run_for(run_id, Action.PUBLISH)
    with services().database.writing() as session:
        changed = publication.reveal(session, run_id)
    done = "The run now shows your name."
    return _back(run_id, "" if changed else "The run is not published anonymously.", done)


@page.post("/runs/<row:run_id>/verify")
def verify(run_id: int) -> ResponseReturnValue:
    """Have a published ranked run evaluated again on fresh trials."""
    access.run_for(run_id, Action.VERIFY)
    done = "The run will be evaluated again on fresh trials, after the runs of users."
    try:
        publication.verify(run_id)
    except VerificationRefused as refusal:
        return _back(run_id, str(refusal))
    return _back(run_id, "", done)


@dataclass(frozen=True, slots=True, kw_only=True)
class Card:
    """What the page of a public run says of its publication."""

    address: str
    bibtex: str
    qualifier: str  # what the run is; empty for a ranked one
    badge: str  # its picture and its snippets for pages elsewhere
    markdown: str
    html: str
    iframe: str
    marks: Sequence[VerificationView]  # the newest first
    pending: bool  # a verification is
    verifiable: bool  # by the viewer


def card_of(run: RunView) -> Card | None:
    """Return what the page says of the publication of a run; None if it is not public."""
    if not run.public:
        return None
    with services().database.reading() as session:
        marks = verifications.of_run(session, run.id)
        pending = verifications.is_pending(session, run.id)
    may = can(access.viewer(), Action.VERIFY, run)
    address, site = publication.address_of(run.id), site_address()
    badge, name = f"{site}/api/v1/runs/{run.id}/badge.svg", _name(run)
    repeats = not marks or can(access.viewer(), Action.ADMINISTER)
    return Card(
        address=address,
        bibtex=citations.bibtex(citation_of(run)),
        qualifier=qualifier(run),
        badge=badge,
        markdown=f"[![{name}]({badge})]({address})",
        html=f'<a href="{address}"><img src="{badge}" alt="{name}"></a>',
        iframe=f'<iframe src="{site}{url_for("run.embed", run_id=run.id)}" title="{name}" '
        'width="960" height="720" loading="lazy"></iframe>',
        marks=marks,
        pending=pending,
        verifiable=bool(run.rankable) and run.kind is RunKind.RANKED and may and repeats,
    )


def _name(run: RunView) -> str:
    """Return a text in place of a picture of a run, without any that its owner wrote."""
    words = qualifier(run)
    return f"Run {run.id} of {run.benchmark} on Seamark{f' ({words})' if words else ''}"


def _terms() -> Terms:
    program = request.form.get("content") != "results"
    return Terms(
        method=request.form.get("method", ""),
        program=program,
        licence=(request.form.get("licence") or None) if program else None,
        anonymous=request.form.get("author") == "anonymous",
    )


def _done(run: RunView, terms: Terms) -> str:
    with_program = " with its program" if terms.program and run.has_programs else ""
    how = ", without your name" if terms.anonymous else ""
    return f"The run is now public{with_program}{how}."


def _suggested(run: RunView) -> str:
    return run.method or method_names.suggested(run, title=run.title)


def _form(run: RunView, terms: Terms, error: str) -> str:
    return render_template(
        "publications/form.html",
        run=run,
        benchmark=known_benchmarks.by_name(run.benchmark),
        name=access.viewer().name,
        terms=terms,
        method_max=METHOD_MAX,
        licences=LICENCES,
        no_licence=NONE,
        error=error,
    )


def _day(at: float) -> str:
    return datetime.fromtimestamp(at, UTC).date().isoformat()


def _back(run_id: int, refusal: str, done: str = "") -> ResponseReturnValue:
    flash(refusal or done, "warn" if refusal else "good")
    return redirect(url_for("run.show", run_id=run_id), code=303)

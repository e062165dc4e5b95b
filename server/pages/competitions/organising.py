"""The organiser's pages: make a draft, have it checked, open it, and look after it then."""

from collections.abc import Iterator, Mapping
from datetime import UTC, datetime

from flask import Blueprint, Response, flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.competitions import zones
from seamark.competitions.document import DocumentInvalid, Programs
from seamark.competitions.standings import Ties
from seamark.server.accounts import accounts
from seamark.server.accounts.accounts import AccountRejected
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.permissions import Action
from seamark.server.competitions import competitions
from seamark.server.competitions.competitions import REASON_MAX, CompetitionView
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.judging import check, drafts
from seamark.server.pages.competitions import draft_form, submitted_draft, wording
from seamark.server.pages.competitions.submitted_draft import Brought
from seamark.server.runs.ending import deletion
from seamark.server.web import (
    access,
    body_limits,
    competition_access,
    competition_csv,
    csv_export,
    known_benchmarks,
    template_runs,
)
from seamark.server.web.problems import Problem
from seamark.server.web.rate_limits import SUBMISSIONS, client, limiter
from seamark.server.web.services import services
from seamark.sim.settings.own_files import LIBRARIES

PROGRAM_CHOICES: Mapping[Programs, str] = {
    Programs.HIDDEN: "their team alone",
    Programs.ORGANISER: "their team and you",
    Programs.PUBLIC: "their team and you; everybody those that decided it, at the end",
}
TIE_CHOICES: Mapping[Ties, str] = {
    Ties.EARLIER: "the earlier submission comes first",
    Ties.SHARED: "what the trials do not tell apart shares a place",
}
page = Blueprint("organising", __name__, url_prefix="/competitions")


@page.get("/new")
def new() -> ResponseReturnValue:
    """Show the form of a new draft."""
    access.require_account(Action.ORGANISE)
    fields = draft_form.defaults(datetime.now(UTC))
    if request.args.get("run"):
        fields |= {"source": "run", "run": request.args["run"]}
    return _form(fields, is_fresh=True)


@page.post("/new")
@limiter.limit(SUBMISSIONS, key_func=client)
def create() -> ResponseReturnValue:
    """Make a draft and have it checked, or show the form again with the errors."""
    user_id = access.require_account(Action.ORGANISE)
    posted, settings = body_limits.form_fields(), services().settings
    brought = Brought()
    try:
        submitted_draft.store(posted, brought)
        draft = submitted_draft.read(posted, brought, earlier=None)
        with services().database.writing() as session:
            name = drafts.create(session, user_id, draft, settings)
            access.record(session, AuditAction.COMPETITION_CREATED, name)
    except (DocumentInvalid, *submitted_draft.REFUSALS) as refusal:
        return _form(posted, _errors(refusal), brought=brought), 422
    services().wake_worker()
    return _show(name)


@page.get("/<name>/change")
def edit(name: str) -> ResponseReturnValue:
    """Show the form of a draft."""
    competition = _draft(name)
    return _form(draft_form.of_document(competition.document), competition=competition)


@page.post("/<name>/change")
@limiter.limit(SUBMISSIONS, key_func=client)
def change(name: str) -> ResponseReturnValue:
    """Replace a draft and have it checked again, or show the form again with the errors."""
    competition = _draft(name)
    posted, settings = body_limits.form_fields(), services().settings
    brought = Brought()
    try:
        submitted_draft.store(posted, brought)
        draft = submitted_draft.read(posted, brought, earlier=competition)
        with services().database.writing() as session:
            forgotten = drafts.change(session, competition, draft, settings)
    except (DocumentInvalid, *submitted_draft.REFUSALS) as refusal:
        errors = _errors(refusal)
        return _form(posted, errors, competition=competition, brought=brought), 422
    deletion.remove_files(settings, forgotten)
    services().wake_worker()
    return _show(draft.document.name)


@page.post("/<name>/delete")
def delete(name: str) -> ResponseReturnValue:
    """Delete a draft."""
    competition = competition_access.organised(name)
    try:
        with services().database.writing() as session:
            forgotten = drafts.remove(session, competition)
    except CompetitionRefused as refusal:
        flash(str(refusal), "bad")
        return _show(name)
    deletion.remove_files(services().settings, forgotten)
    flash("The draft has been deleted.", "good")
    return redirect(url_for("competitions.index"), code=303)


@page.post("/<name>/open")
def open_up(name: str) -> ResponseReturnValue:
    """Show a draft to everybody, and freeze it."""
    competition = competition_access.organised(name)
    try:
        with services().database.writing() as session:
            check.open_up(session, competition)
            detail = {"digest": competition.digest}
            access.record(session, AuditAction.COMPETITION_OPENED, name, detail)
    except CompetitionRefused as refusal:
        flash(str(refusal), "bad")
    else:
        flash("The competition is open: everybody sees it, and what it asks is frozen.", "good")
    return _show(name)


@page.get("/<name>/organise")
def manage(name: str) -> ResponseReturnValue:
    """Show what the organiser of an open competition can do."""
    return _manage(competition_access.organised(name))


@page.post("/<name>/rounds/<int:number>/move")
def move(name: str, number: int) -> ResponseReturnValue:
    """Move the end of a round, or the beginning of a final."""
    competition, form = competition_access.organised(name), request.form
    try:
        until = _time(form.get("until", ""), competition.document.zone)
        with services().database.writing() as session:
            reason = form.get("reason", "")
            competitions.move_round(session, competition, number, until, reason)
            detail = {"round": number, "until": until, "reason": reason}
            access.record(session, AuditAction.ROUND_MOVED, name, detail)
    except CompetitionRefused as refusal:
        return _manage(competition, {f"{refusal.field}{number}": str(refusal)}), 422
    flash("The round has been moved. Everybody sees when and why.", "good")
    return redirect(url_for("organising.manage", name=name), code=303)


@page.post("/<name>/hand-over")
def hand_over(name: str) -> ResponseReturnValue:
    """Give a competition to another organiser."""
    competition, to = competition_access.organised(name), request.form.get("user", "").strip()
    try:
        with services().database.writing() as session:
            user = accounts.person(session, to)
            competitions.hand_over(session, competition, user.id)
            access.record(session, AuditAction.COMPETITION_HANDED_OVER, name, {"to": user.name})
    except (CompetitionRefused, AccountRejected) as refusal:
        return _manage(competition, {"user": str(refusal)}), 422
    flash(f"{to} organises the competition now.", "good")
    return _show(name)


@page.get("/<name>/teams.csv")
def teams_csv(name: str) -> ResponseReturnValue:
    """Download the teams with their members."""
    competition = competition_access.organised(name)
    lines = competition_csv.team_lines(services().database, competition)
    return _csv(lines, f"{name}-teams.csv")


@page.get("/<name>/entries.csv")
def entries_csv(name: str) -> ResponseReturnValue:
    """Download what all teams submitted."""
    competition = competition_access.organised(name)
    lines = competition_csv.entry_lines(services().database, competition)
    return _csv(lines, f"{name}-entries.csv")


def _draft(name: str) -> CompetitionView:
    """Return a draft of the viewer."""
    competition = competition_access.organised(name)
    if not competition.is_draft:
        raise Problem("conflict", competitions.FROZEN)
    return competition


def _csv(lines: Iterator[str], name: str) -> Response:
    answer = Response(lines, content_type=csv_export.MEDIA_TYPE)
    answer.headers.set("Content-Disposition", "attachment", filename=name)
    return answer


def _errors(refusal: Exception) -> dict[str, str]:
    if isinstance(refusal, DocumentInvalid):
        return refusal.errors
    field = getattr(refusal, "field", "")
    return {field if field in ("name", submitted_draft.PICTURE) else "": str(refusal)}


def _time(text: str, zone: str) -> float:
    """Return a posted time [s since 1970] on the clocks of a zone; raises CompetitionRefused."""
    try:
        return zones.to_utc(datetime.fromisoformat(text.strip()), zone).timestamp()
    except (ValueError, OverflowError) as error:
        sentence = str(error) if zone in str(error) else "Choose a date and a time."
        raise CompetitionRefused(sentence, field="until") from None


def _manage(competition: CompetitionView, errors: Mapping[str, str] | None = None) -> str:
    return render_template(
        "competitions/organise.html",
        competition=competition,
        kinds=wording.ROUND_KINDS,
        reason_max=REASON_MAX,
        errors=errors or {},
        posted=request.form,
    )


def _form(
    fields: Mapping[str, str],
    errors: Mapping[str, str] | None = None,
    *,
    competition: CompetitionView | None = None,
    brought: Brought | None = None,
    is_fresh: bool = False,
) -> str:
    return render_template(
        "competitions/form.html",
        competition=competition,
        fields=fields,
        errors=errors or {},
        rounds=draft_form.fieldsets(fields),
        is_fresh=is_fresh,
        zones=sorted(zones.zone_names()),
        benchmarks=known_benchmarks.labels(),
        runs=template_runs.to_choose(fields.get("run", "")),
        kinds=wording.ROUND_KINDS,
        programs=PROGRAM_CHOICES,
        ties=TIE_CHOICES,
        picture_max=drafts.PICTURE_MAX_BYTES,
        libraries=LIBRARIES,
        kept={} if brought is None else brought.tokens(errors or {}),
    )


def _show(name: str) -> ResponseReturnValue:
    return redirect(url_for("competitions.show", name=name), code=303)

"""Computing a set of runs again, for admins: choose, preview, compare, accept or discard."""

from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta

from flask import flash, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts.audit import Actor
from seamark.server.administration import rejudge_choice, rejudgements
from seamark.server.administration.rejudge_choice import RunChoice
from seamark.server.administration.rejudgements import RejudgementRefused, RejudgementView
from seamark.server.pages.administration.admin_page import admin_page
from seamark.server.runs.record.states import RunKind
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.services import services
from seamark.sim import registry

ADMIN_PAGE = admin_page(
    "rejudgements", __name__, label="Rejudgements", path="/rejudgements", view="listed"
)
page = ADMIN_PAGE.blueprint
_TEXTS = {"worker": 255, "version": 40}  # [character]
_CHOICES = {
    "benchmark": tuple(registry.BENCHMARKS),
    "kind": tuple(kind.value for kind in RunKind if kind is not RunKind.LOG),
    "language": (rejudge_choice.BUILT_IN, *LANGUAGES),
}


@page.get("")
def listed() -> ResponseReturnValue:
    """List the rejudgements, newest first."""
    after = request.args.get("after", type=int)
    with services().database.reading() as session:
        views, following = rejudgements.page(session, after=after)
    return render_template(
        "admin/rejudgements.html", views=views, next=following, first=after is None
    )


@page.get("/new")
def form() -> ResponseReturnValue:
    """Show the form and, when runs have been chosen, how many they are."""
    return _form(request.args)


@page.post("")
def start() -> ResponseReturnValue:
    """Start to compute the chosen runs again."""
    held, sent = services(), request.form
    try:
        choice = _choice(sent)
        if choice is None:
            raise RejudgementRefused("Choose a benchmark.")
        with held.database.writing() as session:
            reason = sent.get("reason", "")[: rejudgements.REASON_MAX + 1]
            number = rejudgements.start(session, access.actor(), choice, reason, held.settings)
    except RejudgementRefused as reason:
        return _form(sent, error=str(reason)), 422
    held.wake_worker()
    return redirect(url_for("rejudgements.show", rejudgement_id=number), code=303)


@page.get("/<row:rejudgement_id>")
def show(rejudgement_id: int) -> ResponseReturnValue:
    """Show the progress of a rejudgement and the results that differ."""
    after = request.args.get("after", type=int)
    with services().database.reading() as session:
        rejudgement = _view(session, rejudgement_id)
        listed = rejudgements.differences(
            session, rejudgement.row, after=after, limit=rejudgements.PAGE + 1
        )
    shown = listed[: rejudgements.PAGE]
    return render_template(
        "admin/rejudgement.html",
        row=rejudgement.row,
        progress=rejudgement.progress,
        differences=shown,
        next=shown[-1].key if len(listed) > len(shown) else None,
        first=after is None,
    )


@page.post("/<row:rejudgement_id>/accept")
def accept(rejudgement_id: int) -> ResponseReturnValue:
    """Replace the results that differ."""
    done = "The new results are in place. The earlier ones are kept on the pages of the runs."
    return _decide(rejudgements.accept, rejudgement_id, done)


@page.post("/<row:rejudgement_id>/discard")
def discard(rejudgement_id: int) -> ResponseReturnValue:
    """End a rejudgement without changing a result."""
    return _decide(rejudgements.discard, rejudgement_id, "Discarded. No result has changed.")


def _decide(
    change: Callable[[Session, Actor, int], None], rejudgement_id: int, done: str
) -> ResponseReturnValue:
    try:
        with services().database.writing() as session:
            _view(session, rejudgement_id)
            change(session, access.actor(), rejudgement_id)
        flash(done, "good")
    except RejudgementRefused as reason:
        flash(str(reason), "warn")
    return redirect(url_for("rejudgements.show", rejudgement_id=rejudgement_id), code=303)


def _view(session: Session, rejudgement_id: int) -> RejudgementView:
    rejudgement = rejudgements.show(session, rejudgement_id)
    if rejudgement is None:
        raise Problem("not-found", f"There is no rejudgement {rejudgement_id}.")
    return rejudgement


def _form(sent: Mapping[str, str], *, error: str = "") -> str:
    chosen = None
    try:
        choice = _choice(sent)
        if choice is not None:
            with services().database.reading() as session:
                chosen = rejudge_choice.choose(session, choice)
    except RejudgementRefused as reason:
        error = error or str(reason)
    return render_template(
        "admin/rejudge.html",
        sent=sent,
        chosen=chosen,
        error=error,
        choices=_CHOICES,
        languages={name: language.label for name, language in LANGUAGES.items()},
        texts=_TEXTS,
        seen_max=rejudge_choice.RUNS_MAX,
        reason_max=rejudgements.REASON_MAX,
    )


def _choice(sent: Mapping[str, str]) -> RunChoice | None:
    """Return the chosen runs; None without a benchmark. Raises RejudgementRefused for a date."""
    known = {name: sent.get(name, "") for name in _CHOICES}
    known = {name: value if value in _CHOICES[name] else "" for name, value in known.items()}
    if not known["benchmark"]:
        return None
    texts = {name: sent.get(name, "").strip()[:length] for name, length in _TEXTS.items()}
    first, last = _day(sent, "from"), _day(sent, "to")
    return RunChoice(
        **known,
        **texts,
        ended_from=None if first is None else first.timestamp(),
        ended_to=None if last is None else (last + timedelta(days=1)).timestamp(),
        other_code=sent.get("other_code") == "on",
    )


def _day(sent: Mapping[str, str], name: str) -> datetime | None:
    text = sent.get(name, "").strip()
    if not text:
        return None
    try:
        day = datetime.strptime(text, "%Y-%m-%d").replace(tzinfo=UTC)
    except ValueError:
        raise RejudgementRefused(f"“{text[:20]}” is not a date: write 2026-03-31.") from None
    if not 1970 <= day.year < 5000:
        raise RejudgementRefused("Choose dates from 1970 to 4999.")
    return day

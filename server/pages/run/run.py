"""The page of a run: its state, its data as they arrive, and the actions of its owner."""

from collections.abc import Callable
from datetime import UTC, datetime

from flask import Blueprint, flash, g, make_response, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue
from sqlalchemy.orm import Session

from seamark.formats.registry import FORMATS, Format
from seamark.server.accounts.permissions import Action, can, owns
from seamark.server.pages.previews import link_previews
from seamark.server.pages.publication import publications
from seamark.server.pages.run import level_chart, log_view, metric_tables
from seamark.server.pages.run.player_data import player_data
from seamark.server.pages.run.ranked_parts import ranked_parts
from seamark.server.runs.data import retention, stored_files
from seamark.server.runs.ending import cancellation, deletion
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.recomputation.rejudged import Recomputation
from seamark.server.runs.record import run_notes
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing.comparison import Comparison, comparisons
from seamark.server.runs.showing.views import RunView
from seamark.server.storage import storage
from seamark.server.web import access, class_access, known_benchmarks, publication, security_headers
from seamark.server.web.services import services
from seamark.sim.settings.grid import axes

LOG_SHOWN = 64 * 1024  # [character] of the log on the page; the download has all
LAST_LINES = 40  # of the log, beside the cause of a failure
page = Blueprint("run", __name__, url_prefix="/runs")


@page.get("/<row:run_id>")
def show(run_id: int) -> ResponseReturnValue:
    """Show a run."""
    run = access.run_for(run_id)
    benchmark = known_benchmarks.by_name(run.benchmark)
    config = benchmark.restore(run.config)
    files = stored_files.of_run(services().settings, run)
    may = {action for action in Action if can(g.viewer, action, run)}
    tables = log_view.measured(run, metric_tables.tables(benchmark, run.config, run.metrics or {}))
    log = files.log_text()[-LOG_SHOWN:] if Action.VIEW_LOG in may else ""
    return render_template(
        "run/show.html",
        run=run,
        benchmark=benchmark,
        may=may,
        log=log,
        has_log=Action.VIEW_LOG in may and bool(run.has_programs or log),
        log_end=_last_lines(run, log),
        data_note=_data_note(run),
        title_max=run_notes.TITLE_MAX,
        notes_max=run_notes.NOTES_MAX,
        has_rows=files.row_count() > 0,
        formats=_formats(files.row_count()),
        mission=log_view.of_run(run),
        tracks=log_view.tracks(run),
        connected=run.controller == ROSBRIDGE,
        tables=tables,
        log_number=log_view.key_number(run, tables, benchmark.key_metrics[0].name),
        overall=metric_tables.overall(benchmark, run.metrics or {}),
        level=config.level_metric(),
        axes=axes(config),
        headline=benchmark.headline_of(config),
        level_held_meaning=metric_tables.level_held_meaning(benchmark),
        level_held_unit=benchmark.level_held_unit_of(config),
        trials=metric_tables.trials(run.metrics or {}),
        parts=ranked_parts(run.metrics or {}),
        compared=_compared(run),
        protocol=benchmark.protocol if run.kind is RunKind.RANKED else None,
        curves=level_chart.curves(benchmark, config, run, files),
        parameters=metric_tables.program_parameters(run),
        settings=log_view.settings(
            run,
            benchmark,
            metric_tables.settings(
                *(benchmark, run.config, run.controller), parts=[part.role for part in run.parts]
            ),
        ),
        page_data=player_data(run, files),
        preview=link_previews.of_run(run),
        assignment=class_access.assignment_of_run(run),
        recomputations=_recomputations(run),
        publication=publications.card_of(run),
    )


@page.get("/<row:run_id>/embed")
def embed(run_id: int) -> ResponseReturnValue:
    """Show the player of a run alone, for the frame of another page."""
    run = access.run_for(run_id)
    files = stored_files.of_run(services().settings, run)
    answer = make_response(
        render_template(
            "run/embed.html",
            run=run,
            benchmark=known_benchmarks.by_name(run.benchmark),
            has_rows=files.row_count() > 0,
            axes="",
            protocol=None,
            tracks=log_view.tracks(run),
            page_data=player_data(run, files),
        )
    )
    return security_headers.embeddable(answer, services().settings.embed_origins)


@page.post("/<row:run_id>/cancel")
def cancel(run_id: int) -> ResponseReturnValue:
    """Cancel a queued or running run; the data so far is kept."""
    by = access.not_owner(access.run_for(run_id, Action.CANCEL))
    held = services()
    cancelled = cancellation.cancel(held.database, held.redis, run_id, not_owner=by)
    done = "The run is cancelled. What it recorded so far is kept."
    return _back(run_id, cancelled, done, "The run had already ended.")


@page.post("/<row:run_id>/withdraw")
def withdraw(run_id: int) -> ResponseReturnValue:
    """Make a run private again."""
    run = access.run_for(run_id, Action.WITHDRAW)
    done = "The run is private again."
    answer = _change(run_id, publication.withdraw, done, "The run was not public.")
    if can(g.viewer, Action.VIEW, run.model_copy(update={"public": False})):
        return answer
    return redirect(url_for("leaderboard.show", name=run.benchmark), code=303)


@page.post("/<row:run_id>/edit")
def edit(run_id: int) -> ResponseReturnValue:
    """Change the title and the notes of a run."""
    access.run_for(run_id, Action.EDIT)
    title, notes = request.form.get("title", ""), request.form.get("notes", "")
    with services().database.writing() as session:
        run_notes.annotate(session, run_id, title=title, notes=notes)
    return _back(run_id, True, "Title and notes have been saved.", "")


@page.post("/<row:run_id>/delete")
def delete(run_id: int) -> ResponseReturnValue:
    """Delete a run with its data."""
    access.run_for(run_id, Action.DELETE)
    current = services()
    if not deletion.delete(current.database, current.settings, [run_id]):
        return _back(run_id, False, "", deletion.WHY_NOT)
    flash(f"Run {run_id} has been deleted.", "good")
    return redirect(url_for("runs.mine"), code=303)


@page.post("/<row:run_id>/delete-data")
def delete_data(run_id: int) -> ResponseReturnValue:
    """Delete the data of a run."""
    access.run_for(run_id, Action.DELETE_DATA)
    current = services()
    deleted = retention.delete(current.database, current.settings, [run_id])
    return _back(run_id, bool(deleted), "The data of the run has been deleted.", retention.WHY_NOT)


def _last_lines(run: RunView, log: str) -> str:
    """Return the end of the log of a failed run; of one without its data, what the row has kept."""
    if run.state is not RunState.FAILED:
        return ""
    kept = run.detail.get("log_tail") or ""
    text: str = log or (kept if isinstance(kept, str) else "\n".join(kept))
    return "\n".join(text.rstrip().splitlines()[-LAST_LINES:])


def _formats(rows: int) -> list[tuple[Format, str]]:
    """Return the formats that the page folds, each with why the run cannot be written in it."""
    return [(kind, kind.refusal(rows)) for kind in FORMATS.values() if kind.folded]


def _data_note(run: RunView) -> str:
    """Return why the page has no data of the run; empty if it has."""
    if run.data_deleted_at is not None:
        on = datetime.fromtimestamp(run.data_deleted_at, UTC).date()
        return f"The data of this run was deleted on {on}. Its result and configuration are kept."
    if storage.is_away(services().settings):
        return "The recorded data cannot be read at the moment. Reload the page later."
    return ""


def _compared(run: RunView) -> list[Comparison]:
    """Return the comparisons on the reference trials; the previous run is for its owner alone."""
    if run.kind is not RunKind.RANKED:
        return []
    own = run.user_id is not None and owns(g.viewer, run) and can(g.viewer, Action.LIST)
    with services().database.reading() as session:
        return comparisons(session, run.id, with_previous=own)


def _recomputations(run: RunView) -> list[Recomputation]:
    """Return when and why the result of a run was computed again."""
    with services().database.reading() as session:
        return rejudged.history(session, run.id)


def _change(
    run_id: int, change: Callable[[Session, int], bool], done: str, too_late: str
) -> ResponseReturnValue:
    with services().database.writing() as session:
        changed = change(session, run_id)
    return _back(run_id, changed, done, too_late)


def _back(run_id: int, changed: bool, done: str, too_late: str) -> ResponseReturnValue:
    flash(done if changed else too_late, "good" if changed else "warn")
    return redirect(url_for("run.show", run_id=run_id), code=303)

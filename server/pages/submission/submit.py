"""Submit a run: the form of a benchmark."""

from dataclasses import replace

from flask import Blueprint, g, redirect, render_template, url_for
from flask.typing import ResponseReturnValue

from seamark.programs import archives, declarations, file_types, trial_limits
from seamark.programs.parts import field as part_field
from seamark.programs.preparation import TEXT_MAX_BYTES, UploadRejected
from seamark.programs.setting_values import differences
from seamark.sandbox.languages import DEFAULT_LANGUAGE, LANGUAGES, editor_starters, kinds
from seamark.server.accounts.permissions import Action, can
from seamark.server.judging import entries
from seamark.server.messaging import workers
from seamark.server.pages.benchmark import form_fields
from seamark.server.pages.submission import (
    own_parameters,
    prefill,
    submitted_parts,
    submitted_program,
    submitted_vehicle,
    sweep_fields,
)
from seamark.server.pages.submission.prefill import Prefill
from seamark.server.programs import vehicles
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle, VehicleRejected
from seamark.server.runs.record import method_names, run_notes
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.submission import assigned, quota, submission, sweeps, validation
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import UPLOAD, Submission, SubmissionRejected
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web import access, authentication, body_limits, known_benchmarks
from seamark.server.web.rate_limits import SUBMISSIONS, client, limiter
from seamark.server.web.services import services
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.vehicles.toml_reading import BYTES_MAX as VEHICLE_MAX_BYTES

_DIGITS_MAX = 18
page = Blueprint("submit", __name__, url_prefix="/submit")


@page.get("/")
def first() -> ResponseReturnValue:
    """Redirect to the form of the first benchmark."""
    return redirect(url_for("submit.form", name=known_benchmarks.first().name))


@page.get("/<name>")
def form(name: str) -> ResponseReturnValue:
    """Show the form with the defaults, a preset, or the settings of a run."""
    benchmark = known_benchmarks.by_name(name)
    return _show(benchmark, prefill.initial(benchmark), errors={})


@page.post("/<name>")
@limiter.limit(SUBMISSIONS, key_func=client)
def create(name: str) -> ResponseReturnValue:
    """Submit a run, or show the form again with the errors."""
    benchmark = known_benchmarks.by_name(name)
    access.require_scope(Action.SUBMIT)
    posted = body_limits.form_fields()
    values = form_fields.read(benchmark.schema(), posted)
    program: StoredProgram | None = None
    vehicle: StoredVehicle | None = None
    parts: dict[str, StoredProgram] = {}
    errors: dict[str, str] = {}
    status = 422
    try:
        _require_team(posted)
        if posted.get("controller") == UPLOAD:
            program, errors = _program(benchmark, posted)
        parts, errors_of_parts = submitted_parts.save(benchmark, posted)
        errors |= errors_of_parts
        vehicle = submitted_vehicle.save(values, posted)
        values |= {} if vehicle is None else {vehicles.FIELD: vehicle.name}
        sent = _submission(benchmark, values, posted, program, vehicle)
        sent = replace(sent, parts=parts)
        address = _start(sent, posted, only_check=bool(errors_of_parts))
    except ConfigurationInvalid as refusal:
        errors = refusal.errors | errors
    except VehicleRejected as refusal:
        errors = {vehicles.FIELD: refusal.shortened} | errors
    except SubmissionRejected as refusal:
        errors = errors or {_field_of(refusal): str(refusal)}
    except QuotaExceeded as refusal:
        status, errors = 429, {"": str(refusal)}
    except StorageUnavailable as refusal:
        status, errors = 503, {"": str(refusal)}
    if errors:
        left = submitted_vehicle.without_lost(values, vehicle)
        shown = Prefill(values=left, posted=posted, program=program, parts=parts, vehicle=vehicle)
        return _show(benchmark, shown, errors=errors, keep=posted.get("source") != "editor"), status
    services().wake_worker()  # only after the commit: the worker must find the row
    return redirect(address, code=303)


def _require_team(posted: dict[str, str]) -> None:
    """Refuse an entry of who is in no team before anything is stored that no quota counts."""
    if name := posted.get(entries.FIELD):
        access.require(Action.COMPETE)
        with services().database.reading() as session:
            entries.team_in(session, name, g.viewer.user_id)


def _field_of(refusal: SubmissionRejected) -> str:
    """Return the field of the form that is at fault."""
    return prefill.METHOD if refusal.field == entries.METHOD else refusal.field


def _start(sent: Submission, posted: dict[str, str], *, only_check: bool) -> str:
    """Submit the run of a form, or its sweep, and return the address of its page.

    With `only_check` nothing starts, but what is wrong with the rest of the form is raised.
    """
    settings, database = services().settings, services().database
    axes = sweep_fields.read(posted)
    if only_check:
        validation.validate(sent, settings)
        return ""
    if axes and sent.entry is not None:
        raise SubmissionRejected("An entry of a competition is one run, no sweep.", field="sweep")
    if not axes:
        valid = validation.validate(sent, settings)
        with database.writing() as session:
            return url_for("run.show", run_id=submission.submit(session, valid, settings))
    planned = sweeps.plan(sent, axes, settings)
    with database.writing() as session:
        sweep_id = sweeps.submit(session, planned, axes, settings, title=sent.title)
    return url_for("sweep.show", sweep_id=sweep_id)


def _program(
    benchmark: Benchmark, posted: dict[str, str]
) -> tuple[StoredProgram | None, dict[str, str]]:
    """Return the program of a form, or the error to show beside those of the other fields."""
    try:
        return submitted_program.save(benchmark, posted), {}
    except UploadRejected as refusal:
        return None, {"program": str(refusal)}


def _submission(
    benchmark: Benchmark,
    values: dict[str, object],
    posted: dict[str, str],
    program: StoredProgram | None,
    vehicle: StoredVehicle | None,
) -> Submission:
    """Return the submission in a posted form."""
    ranked = posted.get("kind") == RunKind.RANKED
    source = prefill.visible_run(posted.get("from", ""))
    sent = Submission(
        viewer=authentication.become_guest(),
        benchmark=benchmark.name,
        config=values | own_parameters.read(posted),
        kind=RunKind.RANKED if ranked else RunKind.PRACTICE,
        controller=posted.get("controller", ""),
        program=program,
        vehicle=vehicle,
        seed=_whole(posted, "seed", "A seed"),
        trials=_whole(posted, "trials", "The number of trials"),
        title=posted.get("title", ""),
        rerun_of=None if source is None else source.id,
    )
    if posted.get(entries.FIELD):
        with services().database.reading() as session:
            method = posted.get(prefill.METHOD, "")
            return entries.for_competition(
                session, posted[entries.FIELD], method, sent, services().settings
            )
    assignment = _whole(posted, "assignment", "The number of an assignment")
    if assignment is None:
        return sent
    with services().database.reading() as session:
        return assigned.for_assignment(session, assignment, sent)


def _changes_run(posted: dict[str, str], *, fixed: bool) -> bool:
    """Return whether title, seed or trials differ from what the form starts with."""
    if fixed:
        return bool(posted.get("title"))
    named = any(posted.get(name) for name in ("title", "seed"))
    return named or posted.get("trials", "1") not in {"", "1"}


def _whole(posted: dict[str, str], name: str, what: str) -> int | None:
    text = posted.get(name, "").strip()
    if not text:
        return None
    if not text.isdecimal():
        raise ConfigurationInvalid({name: f"{what} must be a whole number, not {text[:20]}."})
    return int(text[:_DIGITS_MAX])  # more digits are outside of any range


def _show(
    benchmark: Benchmark, prefilled: Prefill, *, errors: dict[str, str], keep: bool = True
) -> str:
    settings, posted, program = services().settings, prefilled.posted, prefilled.program
    kept = program if keep else None
    entrant = prefilled.entrant or prefill.entrant_of(posted.get(entries.FIELD, ""))
    assignment = prefill.assignment_of(posted.get("assignment", "")) if entrant is None else None
    by = entrant or assignment
    fixed = {} if by is None else by.fixed()
    values = {**prefilled.values, **fixed}
    schema = benchmark.schema()
    starters = editor_starters(benchmark.role, moves_arm=benchmark.moves_arm)
    fields = {*schema["properties"], "program", "seed", "trials", "sweep", prefill.METHOD}
    given = {**values, **own_parameters.read(posted)}
    shown = own_parameters.fields(benchmark, program, given, errors)
    fields |= {one.field for one in shown}
    fields |= set(map(part_field, benchmark.parts))
    general = [text for name, text in errors.items() if name not in fields]
    groups = form_fields.groups(schema, values, errors, order=benchmark.groups)
    with services().database.reading() as session:
        accepted = [one.name for one in LANGUAGES.values() if benchmark.role in one.roles]
        refusals = workers.upload_refusals(session, accepted, settings)
        used = None if g.viewer.owner is None else quota.used_by(session, g.viewer, settings)
        ranked = can(g.viewer, Action.SUBMIT_RANKED)
        ranked_day = quota.ranked_times(session, g.viewer, benchmark.name) if ranked else []
    return render_template(
        "submit/form.html",
        benchmark=benchmark,
        text_max=TEXT_MAX_BYTES,
        title_max=run_notes.TITLE_MAX,
        method_max=method_names.METHOD_MAX,
        benchmarks=known_benchmarks.menu(),
        newer=known_benchmarks.newer_than(benchmark.name),
        groups=groups,
        changed=sum(group.changed for group in groups if not (fixed and group.scenario)),
        run_changed=_changes_run(posted, fixed=by is not None),
        starting_points=benchmark.starting_points,
        presets=schema.get("x-presets", {}),
        defaults={name: entry["default"] for name, entry in schema["properties"].items()},
        posted=posted,
        assignment=assignment,
        entrant=entrant,
        locked=by is not None,
        fixed=fixed,
        fixed_changes=differences(benchmark, fixed),
        note=prefilled.note,
        errors=errors,
        parameters=shown,
        sweep=sweep_fields.shown(benchmark, program, posted, fixed=by is not None),
        kept=kept
        and {
            "program": kept,
            "token": submitted_program.token(kept, benchmark.role),
        },
        parts=submitted_parts.fields(
            benchmark,
            [name for name, refusal in refusals.items() if not refusal],
            prefilled.parts,
            errors,
        ),
        vehicle_max=VEHICLE_MAX_BYTES,
        kept_vehicle=prefilled.vehicle and submitted_vehicle.token(prefilled.vehicle),
        archives=archives.SUFFIXES,
        file_names={name: starter.upload_name for name, starter in starters.items()},
        general=" ".join(general),
        languages=[LANGUAGES[name] for name, refusal in refusals.items() if not refusal],
        kinds=kinds(name for name, refusal in refusals.items() if not refusal),
        other_kinds=kinds(name for name in refusals if name != DEFAULT_LANGUAGE),
        packed=file_types.packed(),
        declaring=declarations.MARKS,
        unavailable={LANGUAGES[name].label: why for name, why in refusals.items() if why},
        default_language=DEFAULT_LANGUAGE,
        examples={name: starter.text() for name, starter in starters.items() if not refusals[name]},
        uploads=can(g.viewer, Action.UPLOAD),
        ranked=ranked,
        ranked_day=len(ranked_day),
        upload_refusal=None if None in refusals.values() else next(iter(refusals.values())),
        quota=used,
        settings=settings,
        limits=trial_limits.for_trial(benchmark.trial_duration_s(benchmark.read({}))),
    )

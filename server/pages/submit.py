"""Order a run: the form of a benchmark, and what comes back from it."""

from typing import Any

from flask import Blueprint, g, redirect, render_template, request, url_for
from flask.typing import ResponseReturnValue

from seamark.sandbox.languages import LANGUAGES
from seamark.server import workers
from seamark.server.accounts.permissions import Action, can
from seamark.server.pages import benchmarks, form_fields, submitted_program
from seamark.server.programs import archives, starter_files
from seamark.server.programs.store import TEXT_MAX_BYTES, StoredProgram, UploadRejected
from seamark.server.runs import submission, trial_limits, views
from seamark.server.runs.states import RunKind
from seamark.server.runs.submission import UPLOAD, QuotaExceeded, Submission, SubmissionRejected
from seamark.server.web import authentication
from seamark.server.web.rate_limits import ORDER, limiter, who
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_number
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import ConfigurationInvalid

_DIGITS_MAX = 18
page = Blueprint("submit", __name__, url_prefix="/submit")


@page.get("/")
def first() -> ResponseReturnValue:
    """Go to the form of the first benchmark."""
    return redirect(url_for("submit.form", name=benchmarks.first().name))


@page.get("/<name>")
def form(name: str) -> ResponseReturnValue:
    """Show the form with the defaults, those of a vehicle, or those of an earlier run."""
    benchmark = benchmarks.by_name(name)
    return _show(benchmark, _start_values(benchmark), answers={}, errors={})


@page.post("/<name>")
@limiter.limit(ORDER, key_func=who)
def create(name: str) -> ResponseReturnValue:
    """Queue a run, or show the form again with the reason why not."""
    benchmark = benchmarks.by_name(name)
    answers = request.form.to_dict()
    values = form_fields.read(benchmark.schema(), answers)
    program: StoredProgram | None = None
    refused: dict[str, str] = {}
    status = 422
    try:
        if answers.get("controller") == UPLOAD:
            program, refused = _sent(benchmark, answers)
        order = _order(benchmark, values, answers, program)
        if not refused:
            with services().database.writing() as session:
                run_id = submission.enqueue(session, order, services().settings)
    except ConfigurationInvalid as refusal:
        refused = refusal.errors | refused
    except (SubmissionRejected, QuotaExceeded) as refusal:
        status = 429 if isinstance(refusal, QuotaExceeded) else 422
        refused = {"": str(refusal)}
    if refused:
        kept = program if answers.get("source") != "editor" else None
        return _show(benchmark, values, answers=answers, errors=refused, kept=kept), status
    services().ring()  # only after the commit: the worker must find the row
    return redirect(url_for("run.show", run_id=run_id), code=303)


def _sent(
    benchmark: Benchmark, answers: dict[str, str]
) -> tuple[StoredProgram | None, dict[str, str]]:
    """Return the program of a form, or why it is none, beside what else is wrong."""
    try:
        return submitted_program.take(benchmark, answers), {}
    except UploadRejected as refusal:
        return None, {"program": str(refusal)}


def _order(
    benchmark: Benchmark,
    values: dict[str, object],
    answers: dict[str, str],
    program: StoredProgram | None,
) -> Submission:
    """Return the order in a posted form."""
    kind = RunKind.RANKED if answers.get("kind") == RunKind.RANKED else RunKind.PRACTICE
    if kind is RunKind.RANKED:  # the scenario is the benchmark's, whatever the form says
        values = form_fields.solution(benchmark.schema(), values)
    config = benchmark.read(values)
    trials = _whole(answers, "trials", "The number of trials")
    return Submission(
        viewer=authentication.become_guest(),
        benchmark=benchmark.name,
        config=config.model_dump(mode="json"),
        kind=kind,
        controller=answers.get("controller", ""),
        program=program,
        seed=None if kind is RunKind.RANKED else _whole(answers, "seed", "A seed"),
        trials=1 if trials is None else trials,
        title=answers.get("title", ""),
    )


def _whole(answers: dict[str, str], name: str, what: str) -> int | None:
    text = answers.get(name, "").strip()
    if not text:
        return None
    if not text.isdecimal():
        raise ConfigurationInvalid({name: f"{what} is a whole number, 0 or more, not {text[:20]}."})
    return int(text[:_DIGITS_MAX])  # more digits are out of every range


def _start_values(benchmark: Benchmark) -> dict[str, object]:
    """Return what an empty form begins with."""
    earlier = request.args.get("from", type=row_number)
    if earlier is not None:
        with services().database.reading() as session:
            run = views.show(session, earlier)
        if run is not None and run.benchmark == benchmark.name and can(g.viewer, Action.VIEW, run):
            return dict(run.config)
    return {
        name: request.args[name]
        for name, choices in benchmark.presets.items()
        if request.args.get(name) in choices
    }


def _first_choice(benchmark: Benchmark) -> str:
    """Return what is chosen on an empty form: what the address says, else the first."""
    wanted = request.args.get("controller", "")
    return wanted if wanted in benchmark.built_in else next(iter(benchmark.built_in))


def _show(
    benchmark: Benchmark,
    values: dict[str, object],
    *,
    answers: dict[str, str],
    errors: dict[str, str],
    kept: StoredProgram | None = None,
) -> str:
    held = services()
    schema = benchmark.schema()
    unknown = {key: text for key, text in errors.items() if key not in _places(schema)}
    with held.database.reading() as session:
        refusals = {
            language.name: workers.upload_refusal(session, language.name, held.settings)
            for language in LANGUAGES.values()
            if benchmark.role in language.roles
        }
        quota = (
            None if g.viewer.owner is None else submission.quota(session, g.viewer, held.settings)
        )
    return render_template(
        "submit/form.html",
        benchmark=benchmark,
        text_max=TEXT_MAX_BYTES,
        benchmarks=benchmarks.labels(),
        groups=form_fields.groups(schema, values, errors, order=benchmark.groups),
        presets=schema.get("x-presets", {}),
        defaults={name: entry["default"] for name, entry in schema["properties"].items()},
        answers=answers or {"controller": _first_choice(benchmark)},
        errors=errors,
        kept=kept and {"program": kept, "token": submitted_program.token(benchmark, kept)},
        archives=archives.SUFFIXES,
        file_names=starter_files.FILES[benchmark.role],
        general=" ".join(unknown.values()),
        languages=[LANGUAGES[name] for name, refusal in refusals.items() if not refusal],
        refused={LANGUAGES[name].label: refusal for name, refusal in refusals.items() if refusal},
        examples={
            name: starter_files.of(name, benchmark.role)
            for name in starter_files.FILES[benchmark.role]
            if not refusals[name]
        },
        uploads=can(g.viewer, Action.UPLOAD),
        ranked=can(g.viewer, Action.SUBMIT_RANKED),
        upload_refusal=None if None in refusals.values() else refusals["python"],
        quota=quota,
        settings=held.settings,
        limits=trial_limits.for_trial(benchmark.trial_duration_s(benchmark.read({}))),
    )


def _places(schema: dict[str, Any]) -> set[str]:
    """Return where an error has a place of its own on the form."""
    return {*schema["properties"], "program", "seed", "trials"}

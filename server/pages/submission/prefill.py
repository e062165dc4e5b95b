"""What the form of a new run shows at first: defaults, presets of the URL, or an earlier run."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from flask import g, request

from seamark.sandbox.languages import LANGUAGES, editor_starters
from seamark.server.accounts.permissions import Action, can, owns
from seamark.server.classes import assignments
from seamark.server.classes.assignments import AssignmentView
from seamark.server.classes.refusals import ClassRefused
from seamark.server.competitions import competitions, teams
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.competitions.teams import TeamView
from seamark.server.database.tables import Run
from seamark.server.judging import entries
from seamark.server.programs import store, vehicles
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.record.solutions import ROSBRIDGE
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing import views
from seamark.server.runs.showing.views import RunView
from seamark.server.runs.submission.submission import parts_of, program_of
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.server.web import class_access
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_id
from seamark.sim.benchmarks.benchmark import Benchmark

_DELETED = "it has been deleted"
METHOD = "entry_method"  # field of an entry's method; benchmarks have a setting "method"
_NOT_OF_ENTRIES = ("kind", "seed", "trials", "title")  # fields that a competition decides
EDITED_MAX_BYTES = 256 * 1024  # a larger program is kept as a file, not shown in the editor


@dataclass(frozen=True, slots=True)
class Entrant:
    """A team and the round of a competition that it can submit to now."""

    competition: CompetitionView
    round: RoundView
    team: TeamView
    methods: tuple[str, ...]  # that it has submitted, the newest first
    left: int  # submissions of this round

    def fixed(self) -> dict[str, object]:
        """Return setting -> value of what the competition fixes."""
        return entries.fixed(self.competition, services().settings)


@dataclass(frozen=True, slots=True, kw_only=True)
class Prefill:
    """The initial contents of a form."""

    values: dict[str, object]  # setting -> value; the others have their defaults
    posted: dict[str, str] = field(default_factory=dict)  # the other fields of the form
    program: StoredProgram | None = None  # kept, so that no file has to be chosen again
    parts: Mapping[str, StoredProgram] = field(default_factory=dict)  # role -> program, kept too
    vehicle: StoredVehicle | None = None  # kept too
    entrant: Entrant | None = None  # of an entry
    note: str = ""  # a sentence: where it is from, and what is missing


def initial(benchmark: Benchmark) -> Prefill:
    """Return what the URL asks for: a competition, an assignment, a run, a preset, or a choice."""
    run = _requested_run(benchmark)
    name = _competition(run)
    entrant = entrant_of(name)
    if entrant is not None and entrant.competition.document.benchmark == benchmark.name:
        return _for_competition(benchmark, entrant, run)
    if name and "competition" in request.args:
        shown = _without_competition(benchmark, run)
        return replace(shown, note=f"{_not_entered(name)} {shown.note}".strip())
    return _without_competition(benchmark, run)


def _without_competition(benchmark: Benchmark, run: RunView | None) -> Prefill:
    assignment = _assignment(run)
    if assignment is not None and assignment.benchmark == benchmark.name:
        return _for_assignment(benchmark, assignment, run)
    if run is not None:
        return _without_files(_from_run(benchmark, run), run)
    point = benchmark.starting_points.get(request.args.get("preset", ""))
    controller = point.built_in if point is not None else request.args.get("controller", "")
    known = controller in benchmark.built_in
    chosen: dict[str, object] = {
        name: request.args[name]
        for name, choices in benchmark.presets.items()
        if request.args.get(name) in choices
    }
    return Prefill(
        values=chosen if point is None else dict(point.config),
        posted={"controller": controller if known else next(iter(benchmark.built_in))},
    )


def assignment_of(text: str) -> AssignmentView | None:
    """Return the assignment in a URL or form if the viewer may submit runs for it now."""
    try:
        with services().database.reading() as session:
            return assignments.open_for(session, row_id(text), g.viewer.user_id)
    except (ValueError, ClassRefused):
        return None


def entrant_of(name: str) -> Entrant | None:
    """Return who submits to the competition in a URL or form, if the viewer may do so now."""
    if not name:
        return None
    with services().database.reading() as session:
        competition = competitions.find(session, name)
        if competition is None or competition.current is None:
            return None
        team = teams.of_user(session, competition.id, g.viewer.user_id)
        if team is None:
            return None
        own = entries.own(session, competition, team.id)
    methods = tuple(dict.fromkeys(entry.method for entry in own))
    left = max(entries.left(own, competition.current), 0)
    return Entrant(competition, competition.current, team, methods, left)


def _competition(run: RunView | None) -> str:
    """Return the competition of the URL, or else the one that the run of a team's counts in."""
    if "competition" in request.args:
        return request.args["competition"]
    if run is None or run.entry is None or g.viewer.user_id not in run.entry.members:
        return ""
    return run.entry.competition


def _not_entered(name: str) -> str:
    return f"You cannot submit to {name[:60]} now: no round is open, or you are in no team."


def _assignment(run: RunView | None) -> AssignmentView | None:
    """Return the assignment of the URL, or else the one of the viewer's own run; None if closed."""
    if "assignment" in request.args:
        return assignment_of(request.args["assignment"])
    if run is None or not owns(g.viewer, run):
        return None
    handed_in = class_access.assignment_of_run(run)
    return None if handed_in is None else assignment_of(str(handed_in.id))


def visible_run(text: str) -> RunView | None:
    """Return the run whose id is in a URL or form, if there is one and the viewer may see it."""
    try:
        run_id = row_id(text)
    except ValueError:
        return None
    with services().database.reading() as session:
        run = views.show(session, run_id)
    return run if run is not None and can(g.viewer, Action.VIEW, run) else None


def _requested_run(benchmark: Benchmark) -> RunView | None:
    run = visible_run(request.args.get("from", ""))
    return run if run is not None and run.benchmark == benchmark.name else None


def _from_run(benchmark: Benchmark, run: RunView) -> Prefill:
    """Return the form of a run: the same program, configuration, kind and seed."""
    vehicle, why_not = _vehicle(run)
    shown = _with_parts(_with_program(benchmark, run), run)
    if not why_not:
        return replace(shown, vehicle=vehicle)
    values = {name: value for name, value in shown.values.items() if name != vehicles.FIELD}
    return replace(
        shown, values=values, note=f"{shown.note} It does not have its vehicle: {why_not}."
    )


def _without_files(shown: Prefill, run: RunView) -> Prefill:
    """Return the form without files that it cannot send, and with a note about them."""
    settings = {one.setting for one in run.files}
    if not settings:
        return shown
    values = {name: value for name, value in shown.values.items() if name not in settings}
    note = f"{shown.note} It does not have its record of currents, which this form cannot send."
    return replace(shown, values=values, note=note)


def _with_parts(shown: Prefill, run: RunView) -> Prefill:
    """Return the form with the further programs of a run, or with a note about those it lacks."""
    if not run.parts:
        return shown
    own = " and ".join(f"own {part.role}" for part in run.parts)
    why_not = _why_not(run)
    if not why_not:
        try:
            with services().database.reading() as session:
                kept = parts_of(session.get_one(Run, run.id), services().settings)
        except SubmissionRejected:
            why_not = _DELETED
        else:
            return replace(shown, parts=kept)
    return replace(shown, note=f"{shown.note} It does not have its {own}: {why_not}.")


def _with_program(benchmark: Benchmark, run: RunView) -> Prefill:
    ranked = run.kind is RunKind.RANKED and can(g.viewer, Action.SUBMIT_RANKED)
    posted = {
        "controller": run.controller,
        "kind": RunKind.RANKED if ranked else RunKind.PRACTICE,
        "seed": "" if run.seed is None else str(run.seed),
        "trials": str(run.trials) if run.kind is RunKind.PRACTICE else "",
        "title": run.title,
        "from": str(run.id),
    }
    what = "configuration" if run.seed is None else "configuration and seed"
    if run.controller == ROSBRIDGE:
        posted["controller"] = next(iter(benchmark.built_in))
        note = f"The form has the {what} of run {run.id}, but not its program, which was connected."
        return Prefill(values=dict(run.config), posted=posted, note=note)
    if run.program_sha256 is None:
        if run.controller not in benchmark.built_in:  # a reference entry, such as the oracle
            posted["controller"] = next(iter(benchmark.built_in))
        return Prefill(
            values=dict(run.config), posted=posted, note=f"The form has the {what} of run {run.id}."
        )
    program, why_not = _program(run)
    if program is None:
        posted["controller"] = next(iter(benchmark.built_in))
        note = f"The form has the {what} of run {run.id}, but not its program: {why_not}."
        return Prefill(values=dict(run.config), posted=posted, note=note)
    joint = ", " if run.seed is not None else " and "
    return Prefill(
        values=dict(run.config),
        posted=posted | _in_editor(benchmark, program),
        program=program,
        note=f"The form has the program{joint}{what} of run {run.id}.",
    )


def _for_assignment(
    benchmark: Benchmark, assignment: AssignmentView, run: RunView | None
) -> Prefill:
    """Return the form of an assignment, with the program of a run if the URL has one too."""
    first = None if run is None else _from_run(benchmark, run)
    posted = {"controller": next(iter(benchmark.built_in))} if first is None else first.posted
    solution = {} if first is None else first.values
    seed = posted.get("seed", "") if assignment.seed is None else str(assignment.seed)
    return Prefill(
        values={**assignment.config, **solution, **assignment.fixed()},
        posted=posted
        | {
            "assignment": str(assignment.id),
            "kind": RunKind.RANKED if assignment.is_ranked else RunKind.PRACTICE,
            "seed": "" if assignment.is_ranked else seed,
            "trials": "" if assignment.is_ranked else str(assignment.trials),
        },
        program=None if first is None else first.program,
        parts={} if first is None else first.parts,
        note="" if first is None else first.note,
    )


def _for_competition(benchmark: Benchmark, entrant: Entrant, run: RunView | None) -> Prefill:
    """Return the form of an entry, with the program of a run if the URL has one too."""
    first = None if run is None else _from_run(benchmark, run)
    posted = {"controller": next(iter(benchmark.built_in))} if first is None else first.posted
    method = "" if run is None or run.entry is None else run.entry.method
    return Prefill(
        values={**({} if first is None else first.values), **entrant.fixed()},
        posted={name: text for name, text in posted.items() if name not in _NOT_OF_ENTRIES}
        | {entries.FIELD: entrant.competition.name, METHOD: method},
        program=None if first is None else first.program,
        parts={} if first is None else first.parts,
        entrant=entrant,
        note="" if first is None else _without_seed(first.note),
    )


def _without_seed(note: str) -> str:
    return note.replace(", configuration and seed", " and configuration").replace(" and seed", "")


def _vehicle(run: RunView) -> tuple[StoredVehicle | None, str]:
    """Return the run's own vehicle, and why the viewer cannot use it again; empty if they can."""
    if run.vehicle_sha256 is None:
        return None, ""
    if not can(g.viewer, Action.UPLOAD):
        return None, "uploading one needs an account"
    try:
        return vehicles.of_run(run, services().settings), ""
    except FileNotFoundError:
        return None, "it has been deleted"


def _program(run: RunView) -> tuple[StoredProgram | None, str]:
    """Return the program of a run, or why the viewer cannot run it again."""
    if why_not := _why_not(run):
        return None, why_not
    try:
        with services().database.reading() as session:
            return program_of(session.get_one(Run, run.id), services().settings), ""
    except SubmissionRejected:
        return None, _DELETED


def _why_not(run: RunView) -> str:
    """Return why the viewer cannot run the programs of a run again; empty if they may."""
    if not can(g.viewer, Action.UPLOAD):
        return "uploading one needs an account"
    return "" if can(g.viewer, Action.VIEW_PROGRAM, run) else "only its owner may read it"


def _in_editor(benchmark: Benchmark, program: StoredProgram) -> dict[str, str]:
    """Return the fields of the editor with the source of a program; none if it is no text.

    The editor is in front if the program was written there: its name says so.
    """
    starter = editor_starters(benchmark.role).get(program.language)
    archive = not program.name.endswith(LANGUAGES[program.language].suffixes)
    if starter is None or archive or program.size > EDITED_MAX_BYTES:
        return {}
    text = store.read(services().settings, program.sha256).decode("utf-8", "replace")
    front = "editor" if program.name == starter.upload_name else "file"
    return {"source": front, "language": program.language, "program_text": text}

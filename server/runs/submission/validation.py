"""The rules of a submission that need no database, for the form, the API, checks and baselines."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from sqlalchemy.orm import Session

from seamark.programs import configurations, parts
from seamark.programs.configurations import RunConfiguration
from seamark.programs.parameters import Parameter
from seamark.sandbox.languages import images_refusal, role_refusal
from seamark.server.accounts.permissions import Action, Viewer, can
from seamark.server.programs import own_files, vehicles
from seamark.server.programs.own_files import StoredFile
from seamark.server.programs.store import StoredProgram
from seamark.server.programs.vehicles import StoredVehicle
from seamark.server.runs.data import run_size
from seamark.server.runs.data.run_size import RunSize
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.submission import ranked_scenario
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.engine.seeds import SEED_MAX
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid

RANKED_VEHICLE = (
    "A ranked run has the vehicle of its benchmark. Start a practice run for one of your own."
)
UPLOAD = "upload"  # the controller of a run whose program was uploaded


class SubmissionRejected(Exception):
    """The submission breaks a rule. The text is for the user; `field` names the part at fault."""

    def __init__(self, sentence: str, *, field: str = "") -> None:
        super().__init__(sentence)
        self.field = field


class SignInNeeded(SubmissionRejected):
    """The viewer has neither an account nor a guest's cookie, so could not find the run again."""


class AccountNeeded(SubmissionRejected):
    """Guests may not submit this."""


@dataclass(frozen=True, slots=True, kw_only=True)
class EntryTerms:
    """What a round of a competition fixes of the runs that are submitted to it."""

    owner: str  # of the run: it belongs to a team, or to the competition
    trials: int
    seed_of: Callable[[str], int]  # seed of a submission, by its digest
    enter: Callable[[Session, int], None]  # records the run's id in the transaction that inserts it


@dataclass(frozen=True, slots=True, kw_only=True)
class Submission:
    """What a user sends, not validated. `config` may leave out settings that have defaults."""

    viewer: Viewer
    benchmark: str
    config: Mapping[str, object]
    kind: RunKind = RunKind.PRACTICE
    controller: str = UPLOAD
    program: StoredProgram | None = None
    parts: Mapping[str, StoredProgram] = field(default_factory=dict)  # role -> further program
    vehicle: StoredVehicle | None = None  # the user's own, practice only; `config` may name it
    files: tuple[StoredFile, ...] = ()  # that `config` names; practice and entries only
    seed: int | None = None  # practice only; None: drawn
    trials: int | None = None  # practice only; None: one
    title: str = ""
    notes: str = ""
    rerun_of: int | None = None
    assignment: int | None = None  # of a class, for which the run is to count
    entry: EntryTerms | None = None  # of a competition, in which the run is to count
    baseline: bool = False  # submitted by the service; may use the benchmark's reference solutions
    connected: bool = False  # its program takes part over the network, see `solutions`


@dataclass(frozen=True, slots=True)
class ValidSubmission:
    """A submission that `validate` accepted, with its complete configuration."""

    submission: Submission
    benchmark: Benchmark
    config: Configuration
    trials: int
    size: RunSize  # what it may record
    whole: RunConfiguration  # as it was sent, with the parameters of the program


def validate(submission: Submission, settings: Settings) -> ValidSubmission:
    """Return the submission with its parsed configuration.

    Raises
    ------
    ConfigurationInvalid
        The configuration is wrong: a sentence for each setting.
    SubmissionRejected, VehicleRejected, FileRejected
        Another rule is broken.
    """
    if submission.vehicle is not None and submission.kind is RunKind.RANKED:
        raise SubmissionRejected(RANKED_VEHICLE, field=vehicles.FIELD)
    with own_files.lent(submission.vehicle, submission.files):
        return _validate(submission, settings)


def _validate(submission: Submission, settings: Settings) -> ValidSubmission:
    benchmark = find_benchmark(submission.benchmark)
    program = submission.program
    declared: tuple[Parameter, ...] = ()
    if program is not None:
        declared = configurations.declared_in(benchmark, program.language, program.parameters)
    whole = configurations.read(benchmark, submission.config, declared)
    config = whole.settings
    require_permission(submission.viewer, kind=submission.kind, uploads=_first_upload(submission))
    config, trials = _by_kind(submission, benchmark, config, settings)
    if (submission.controller == UPLOAD) != (submission.program is not None):
        raise SubmissionRejected(
            f"Choose either a built-in {benchmark.role} or your own program.", field="controller"
        )
    if submission.connected:
        _check_connected(submission, benchmark)
    elif submission.program is None:
        _check_built_in(benchmark, submission.controller, baseline=submission.baseline)
    else:
        check_language(benchmark, submission.program.language)
        _check_images(config, submission.program.language)
    for role, part in submission.parts.items():
        check_part(benchmark, role)
        check_language(benchmark, part.language, role=role)
    programs = [one for one in (program, *submission.parts.values()) if one is not None]
    size = run_size.estimate(
        config,
        trials=trials,
        program_bytes=sum(one.size for one in programs) if programs else None,
        files_bytes=sum(len(one.content) for one in _own_files(submission)),
    )
    refusal = size.refusal(settings.run_max_bytes)
    if refusal is not None and submission.kind is RunKind.PRACTICE:
        raise SubmissionRejected(refusal)
    return ValidSubmission(submission, benchmark, config, trials, size, whole)


def _by_kind(
    submission: Submission, benchmark: Benchmark, config: Configuration, settings: Settings
) -> tuple[Configuration, int]:
    """Return the configuration of a run of its kind, and the number of its trials."""
    if submission.kind is RunKind.RANKED:
        chosen = submission.controller
        ranked = ranked_scenario.apply(
            *(benchmark, submission.config, config), controller=chosen, parts=submission.parts
        )
        return ranked, _ranked_trials(submission, benchmark)
    if submission.entry is None:
        return config, _practice_trials(submission, settings)
    if not submission.baseline and (errors := config.ranking_errors()):
        raise ConfigurationInvalid(errors)
    return config, submission.entry.trials


def find_benchmark(name: str) -> Benchmark:
    """Return a benchmark; raises SubmissionRejected if it does not exist."""
    if name not in registry.BENCHMARKS:
        raise SubmissionRejected(f"There is no benchmark {name}.", field="benchmark")
    return registry.benchmark(name)


def require_permission(
    viewer: Viewer, *, kind: RunKind = RunKind.PRACTICE, uploads: str = ""
) -> None:
    """Raise SubmissionRejected if the viewer may not submit such a run.

    `uploads` is what is uploaded for it: "program", "vehicle", the role of a part or a setting.
    """
    if kind is RunKind.RANKED and not can(viewer, Action.SUBMIT_RANKED):
        raise AccountNeeded("A ranked run needs an account: the leaderboard shows its name.")
    if uploads and not can(viewer, Action.UPLOAD):
        at = parts.field(uploads) if uploads in parts.ROLES else uploads
        raise AccountNeeded(f"Uploading a {uploads} needs an account.", field=at)
    if not can(viewer, Action.SUBMIT):
        raise SignInNeeded("Sign in, or allow cookies: a guest's runs are found by a cookie.")


def check_part(benchmark: Benchmark, role: str) -> None:
    """Raise SubmissionRejected if a run of the benchmark has no part with this role."""
    if refusal := parts.refusal(benchmark, role):
        raise SubmissionRejected(refusal, field=parts.field(role))


def check_language(benchmark: Benchmark, language: str, *, role: str = "") -> None:
    """Raise SubmissionRejected if no program in this language can have the role.

    Without a `role` it is the one of the benchmark; with one the program is a part of the run.
    """
    if role and (refusal := role_refusal(language, role)):
        raise SubmissionRejected(refusal, field=parts.field(role))
    if refusal := role_refusal(language, benchmark.role):
        sentence = f"{benchmark.name} compares {benchmark.role}s. {refusal}"
        raise SubmissionRejected(sentence, field="program")


def _first_upload(submission: Submission) -> str:
    """Return the first of what is uploaded, as `require_permission` names it; empty if nothing."""
    if submission.program is not None:
        return "program"
    vehicle = ("vehicle",) if submission.vehicle is not None else ()
    files = (file.setting for file in submission.files)
    return next(iter((*submission.parts, *vehicle, *files)), "")


def _own_files(submission: Submission) -> tuple[StoredVehicle | StoredFile, ...]:
    vehicle = () if submission.vehicle is None else (submission.vehicle,)
    return (*vehicle, *submission.files)


def _check_images(config: Configuration, language: str) -> None:
    if config.cameras_of_program() and (refusal := images_refusal(language)):
        raise SubmissionRejected(refusal, field="images")


def _ranked_trials(submission: Submission, benchmark: Benchmark) -> int:
    trials = benchmark.ranked_trials
    if submission.seed is not None:
        raise SubmissionRejected(ranked_scenario.SEED_REFUSAL, field="seed")
    if submission.trials not in (None, trials):
        raise SubmissionRejected(ranked_scenario.trials_refusal(trials), field="trials")
    return trials


def _practice_trials(submission: Submission, settings: Settings) -> int:
    trials, trials_max = (
        1 if submission.trials is None else submission.trials,
        settings.practice_trials_max,
    )
    if not 1 <= trials <= trials_max:
        raise SubmissionRejected(f"A practice run has 1 to {trials_max} trials.", field="trials")
    if submission.seed is not None and not 0 <= submission.seed <= SEED_MAX:
        raise SubmissionRejected(f"A seed is a whole number from 0 to {SEED_MAX}.", field="seed")
    return trials


def _check_connected(submission: Submission, benchmark: Benchmark) -> None:
    if benchmark.role != "controller":
        raise SubmissionRejected(
            f"{benchmark.name} evaluates a {benchmark.role}; a bridge connects a controller.",
            field="benchmark",
        )
    if submission.kind is not RunKind.PRACTICE:
        raise SubmissionRejected(
            "A connected program cannot be run again, so its run does not rank: upload the program."
        )


def _check_built_in(benchmark: Benchmark, controller: str, *, baseline: bool) -> None:
    if controller in benchmark.built_in:
        return
    if controller in benchmark.reference_built_in:
        if baseline:
            return
        raise SubmissionRejected(
            f"{benchmark.reference_built_in[controller]} is a reference entry: the service runs it "
            "itself, as a mark on the leaderboard.",
            field="controller",
        )
    choice = f"Choose a {benchmark.role}: {', '.join(benchmark.built_in)}, or your own program."
    unknown = f"{benchmark.name} has no built-in {benchmark.role} {controller}. "
    raise SubmissionRejected(unknown + choice if controller else choice, field="controller")

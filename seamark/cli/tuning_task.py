"""What `seamark tune` was asked for: the solution, what is tuned, and where it runs."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seamark.cli.extras import install_line, missing
from seamark.cli.output_folder import draft_of
from seamark.failures import UsageRefused
from seamark.programs import configurations, parameters
from seamark.programs.setting_values import in_effect
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.position_controllers import UPLOAD
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.tuning.candidates import Evaluator
from seamark.tuning.history import History
from seamark.tuning.methods import Method, method_of
from seamark.tuning.search_space import Dimension, Schema, Value, read_dimensions

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from seamark.programs.parameters import Parameter
    from seamark.programs.preparation import PreparedProgram

PACKAGES = ("cmaes", "optuna", "tomli_w")  # of this extra
_TUNABLE = ("number", "integer", "boolean", "string")
_HISTORY = ".csv"


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """The options of the command."""

    controller: str | None
    params: Sequence[str]
    method: str
    candidates: int
    batch: int
    trials: int
    seed: int
    validate: int
    pairs: Sequence[str]
    config: Path | None
    jobs: int | None
    server: str | None
    token: str | None
    out: Path
    resume: bool
    as_json: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class TuningTask:
    """A checked task."""

    options: Options
    benchmark: Benchmark
    controller: str  # as the option has it
    program: PreparedProgram | None
    declared: tuple[Parameter, ...]  # by the program
    given: Mapping[str, Any]  # settings that all candidates share
    files: dict[str, Any]  # of these, what was given as a file
    space: tuple[Dimension, ...]
    defaults: Mapping[str, Value]  # of what is tuned

    @property
    def names(self) -> list[str]:
        """The names of what is tuned."""
        return [one.name for one in self.space]

    @property
    def jobs(self) -> int:
        """How many candidates run at a time."""
        cores = len(os.sched_getaffinity(0))
        return min(self.options.jobs or cores, self.options.batch)

    @property
    def block(self) -> int:
        """Consecutive trials that belong together (`RankedProtocol.block`)."""
        protocol = self.benchmark.protocol
        return protocol.block if protocol else 1

    @property
    def history_path(self) -> Path:
        """The file of the history."""
        return self.options.out.with_suffix(_HISTORY)

    def configuration(self, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return the configuration of a run; raises ConfigurationInvalid."""
        read = configurations.read(self.benchmark, self._settings(values), self.declared)
        return read.document()

    def write(self, values: Mapping[str, Value]) -> None:
        """Write a configuration as a file for --config."""
        import tomli_w

        lines = f"# seamark run {self.benchmark.name} --controller {self.controller} --config ..."
        text = f"{lines}\n{tomli_w.dumps(self._settings(values) | self.files)}"
        with draft_of(self.options.out) as file:
            file.write(text.encode())

    def evaluator(
        self, *, progress: Callable[[float], None], notice: Callable[[str], None]
    ) -> AbstractContextManager[Evaluator]:
        """Return where candidates run.

        Parameters
        ----------
        progress
            Is called with the progress of a run with the fresh seed, 0 to 1.
        notice
            Is called with a sentence about something that delays the search.

        Raises
        ------
        UsageRefused, PlatformFailed
            The server refuses the token, or does not answer.
        """
        if self.options.server is not None:
            return self._server_runs(self.options.server, progress, notice)
        return self._local_cores(progress, notice)

    @contextmanager
    def _local_cores(
        self, progress: Callable[[float], None], notice: Callable[[str], None]
    ) -> Iterator[Evaluator]:
        from seamark.cli.simulator_loading import compiling_said
        from seamark.cli.solutions import isolation_level
        from seamark.sandbox.isolation.level import IsolationLevel
        from seamark.tuning.local_cores import LocalCores, Solution

        solution = Solution(
            benchmark=self.benchmark.name,
            controller=self.program or self.controller,
            isolation=isolation_level() if self.program else IsolationLevel.NONE,
        )
        cores = LocalCores(
            solution,
            seed=self.options.seed,
            trials=self.options.trials,
            jobs=self.jobs,
            on_progress=progress,
        )
        with compiling_said(notice), cores:
            yield cores

    def _server_runs(
        self, server: str, progress: Callable[[float], None], notice: Callable[[str], None]
    ) -> AbstractContextManager[Evaluator]:
        from seamark.cli.server_answers import refusals_shown
        from seamark.client import AsyncClient, Client
        from seamark.tuning.server_runs import PATIENCE_S, Entry, Listener, ServerRuns, room_for

        with refusals_shown(), Client(server, self.options.token) as client:
            room = room_for(client.account())
        is_program = self.program is not None
        return ServerRuns(
            AsyncClient(server, self.options.token, patience_s=PATIENCE_S),
            Entry(
                benchmark=self.benchmark.name,
                controller=None if is_program else self.controller,
                program=Path(self.controller) if is_program else None,
            ),
            seed=self.options.seed,
            trials=self.options.trials,
            at_a_time=min(room, self.options.jobs or room),
            listener=Listener(progress=progress, notice=notice),
        )

    def history(self) -> History:
        """Return the history: that of an earlier call if it is resumed, else a new file.

        Raises
        ------
        UsageRefused
            There is none to resume; there is one already; the file cannot be written.
        """
        history = History(path=self.history_path, settings=self._identity(), names=self.names)
        if self.options.resume:
            history.load()
        elif self.history_path.exists():
            raise UsageRefused(
                f"{self.history_path} exists: go on with --resume, or choose another --out."
            )
        history.save()
        return history

    def method(self) -> Method:
        """Return how candidates are chosen; raises UsageRefused."""
        return method_of(
            self.options.method,
            self.space,
            start=self.defaults,
            seed=self.options.seed,
            batch=self.options.batch,
            limit=self.options.candidates,
        )

    def _settings(self, values: Mapping[str, Value]) -> dict[str, Any]:
        """Return the settings as a file has them: those of the program in a table of their own."""
        own = {one.name for one in self.declared}
        gathered = parameters.gathered({**self.given, **values}, self.declared)
        below = dict(gathered.get(parameters.KEY) or {})
        below |= {name: value for name, value in values.items() if name in own}
        return {**gathered, **({parameters.KEY: below} if below else {})}

    def _identity(self) -> dict[str, Any]:
        """Return what decides which candidates are tried, and their scores."""
        options, program = self.options, self.program
        sha256 = hashlib.sha256(program.content).hexdigest() if program else ""
        limit = {"candidates": options.candidates} if options.method == "grid" else {}
        return {
            "benchmark": self.benchmark.name,
            "controller": sha256 or self.controller,
            "settings": dict(self.given),
            "parameters": [one.to_json() for one in self.space],
            "method": options.method,
            "batch": options.batch,
            "trials": options.trials,
            "seed": options.seed,
        } | limit


def task_of(name: str, options: Options) -> TuningTask:
    """Return the checked task.

    Raises
    ------
    UsageRefused, ProgramFailed
        The options are wrong; the program would be refused.
    """
    from seamark.cli.configuration import benchmark_of, read_settings, typed, with_files
    from seamark.cli.solutions import choose, prepare_valid

    if missing(PACKAGES):
        raise UsageRefused(f"`seamark tune` needs more packages: {install_line('tune')}.")
    benchmark = benchmark_of(name)
    controller, path = choose(options.controller, name)
    program = None if path is None else prepare_valid(path, benchmark=name)
    declared: tuple[Parameter, ...] = ()
    if program is not None:
        declared = configurations.declared_in(benchmark, program.language, program.parameters)
    written = read_settings(options.config, options.pairs)
    given = typed(written if options.server else with_files(written), benchmark.schema())
    try:
        base = configurations.read(benchmark, given, declared).document()
    except ConfigurationInvalid as error:
        raise UsageRefused(str(error)) from None
    tunable = _tunable(benchmark, base, declared, UPLOAD if program else controller)
    texts = options.params or [one.name for one in declared if None not in (one.low, one.high)]
    space = read_dimensions(texts, tunable)
    values = base | dict(base.get(parameters.KEY) or {})
    return TuningTask(
        options=options,
        benchmark=benchmark,
        controller=controller,
        program=program,
        declared=declared,
        given=given,
        files={key: value for key, value in written.items() if key == "vehicle"},
        space=space,
        defaults={one.name: values[one.name] for one in space},
    )


def _tunable(
    benchmark: Benchmark, config: Mapping[str, Any], declared: Sequence[Parameter], solution: str
) -> dict[str, Schema]:
    """Return name -> schema of what belongs to the solution, and has an effect on it."""
    settings = {
        name: entry
        for name, entry in in_effect(benchmark, config, solution).items()
        if entry["type"] in _TUNABLE and entry["x-role"] != "scenario"
    }
    own = {one.name: one.entry() for one in declared}
    return own | {name: entry for name, entry in settings.items() if name not in own}

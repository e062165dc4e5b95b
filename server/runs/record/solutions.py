"""What the solution of a run is called: a built-in one, an uploaded program, or a connected one.

Nobody can compute a run again whose program was connected over the network.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

from seamark.sandbox.languages.language import TRACKER
from seamark.server.database.tables import Run
from seamark.sim import registry

ROSBRIDGE = "rosbridge"  # the controller of a run whose program was connected
IS_CONNECTED = Run.controller == ROSBRIDGE
_CONNECTED = "ROS program (rosbridge)"


class HasSolution(Protocol):
    """What decides the name; a view and a row of the leaderboard have it."""

    @property
    def benchmark(self) -> str: ...  # noqa: D102 - the attribute of tables.Run
    @property
    def config(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def controller(self) -> str: ...  # noqa: D102
    @property
    def program_name(self) -> str | None: ...  # noqa: D102


class HasRole(Protocol):
    """A further program of a run, of a row or of a view."""

    @property
    def role(self) -> str: ...  # noqa: D102 - the attribute of tables.RunPart


class HasTeam(HasSolution, Protocol):
    """What decides the name of all that takes part in a run."""

    @property
    def parts(self) -> Sequence[HasRole]: ...  # noqa: D102 - the attribute of tables.Run


def team(run: HasTeam) -> str:
    """Return the name of the solution, with the roles of further programs: "PI + own detector"."""
    return " + ".join((solution(run), *(f"own {part.role}" for part in run.parts)))


def built_in_tracker(run: HasTeam) -> str:
    """Return the name of the built-in tracker of a run; empty if a program is the tracker."""
    benchmark = run.benchmark
    if any(part.role == TRACKER for part in run.parts):
        return ""
    if benchmark in registry.BENCHMARKS and registry.benchmark(benchmark).role == "tracker":
        if run.controller not in registry.benchmark(benchmark).built_in:
            return ""
    return str(run.config.get("tracker", ""))


class HasEntryName(HasSolution, Protocol):
    """What decides the name of an entry; a view and a row of the leaderboard have it."""

    @property
    def method(self) -> str: ...  # noqa: D102
    @property
    def title(self) -> str: ...  # noqa: D102


def entry_name(run: HasEntryName) -> str:
    """Return what a published run is called: its method, else its title, else its solution."""
    return run.method or run.title or solution(run)


def solution(run: HasSolution) -> str:
    """Return the name of the program, or the label of the built-in solution."""
    if run.program_name:
        return run.program_name
    if run.controller == ROSBRIDGE:
        return _CONNECTED
    if run.benchmark not in registry.BENCHMARKS:  # of an earlier version
        return run.controller
    return registry.benchmark(run.benchmark).solution_label_of(run.controller, run.config)

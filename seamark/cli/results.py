"""Results that commands are given: folders of `seamark run`, and runs of a server."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.client import Run
    from seamark.plots.result import Result


def is_run(name: str) -> bool:
    """Return whether this is the number of a run on a server; a folder of this name wins."""
    return name.isascii() and name.isdecimal() and not Path(name).is_dir()


def results_of(
    names: Sequence[str], *, server: str | None, token: str | None, telemetry: bool
) -> list[Result]:
    """Return the results in their order, with or without rows; a server is asked only for runs.

    Raises
    ------
    UsageRefused, PlatformFailed
        There is no such result; the server refuses or does not answer.
    """
    from seamark.cli.server_answers import refusals_shown
    from seamark.plots.result import of_folder

    by_name: dict[str, Result] = {}
    for name in names:
        if not is_run(name):
            if not Path(name).is_dir():
                raise UsageRefused(f"{name} is neither a folder nor the number of a run.")
            by_name[name] = of_folder(Path(name), telemetry=telemetry)
    if runs := [name for name in names if is_run(name)]:
        from seamark.client import Client

        with refusals_shown(), Client(server, token) as client:
            by_name |= {name: _of_run(client.run(int(name)), telemetry=telemetry) for name in runs}
    return [by_name[name] for name in names]


def _of_run(run: Run, *, telemetry: bool) -> Result:
    """Return the result of a run that has ended; raises what the client raises."""
    from seamark.plots.result import Result, no_rows

    return Result(
        name=f"run {run.id}",
        manifest=run.manifest(),
        metrics=run.document["metrics"],
        rows=run.telemetry() if telemetry else no_rows(),
    )

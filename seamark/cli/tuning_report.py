"""What `seamark tune` prints: a line for each candidate, a bar on a terminal, the result."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

import click

from seamark.sandbox.printable_text import printable_text
from seamark.tuning.candidates import DEFAULTS, Candidate, Evaluated

if TYPE_CHECKING:
    from seamark.cli.tuning_task import TuningTask
    from seamark.tuning.search import Search
    from seamark.tuning.validation import Validation

_NUMBER, _VALUE, _SCORE = 4, 10, 9  # [character] of the columns
_SHOWN = 4  # parameters in the table; the files have all
_NOTE = 60  # [character] of a remark
_FAILURES_SHOWN = 5


class Report:
    """Prints the candidates as they end.

    A bar below the lines on a terminal, plain lines in a pipe, nothing if `quiet`.
    """

    def __init__(self, task: TuningTask, *, quiet: bool) -> None:
        self._task = task
        self._quiet = quiet
        self._best: float | None = None
        self.ended = 0  # candidates
        self._bar: Any = None
        self._validation: Any = None
        self._validated = 0  # configurations that have had all fresh trials

    @contextmanager
    def searching(self) -> Iterator[None]:
        """Print the head of the table; the candidates end within."""
        if self._quiet:
            yield
            return
        for line in self._head():
            click.echo(line)
        with self._new_bar() as self._bar:
            yield

    def candidate_ended(self, candidate: Candidate, evaluated: Evaluated) -> None:
        """Print a line."""
        self.ended += 1
        better = evaluated.score is not None and (
            self._best is None or evaluated.score > self._best
        )
        if better:
            self._best = evaluated.score
        if self._quiet:
            return
        self._print(self._line(candidate, evaluated, better=better))
        if self._bar is not None:
            self._bar.update(0, completed=self.ended)

    def _print(self, line: str, *, err: bool = False) -> None:
        """Print a line, above the bar if there is one."""
        if self._bar is None:
            click.echo(printable_text(line), err=err)
        else:
            text = printable_text(line)
            self._bar.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def validating(self) -> AbstractContextManager[Any]:
        """Return a context manager with the progress of the runs with the fresh seed."""
        from seamark.progress import Progress

        self._validation = Progress("Fresh trials", quiet=self._quiet)
        bar: AbstractContextManager[Any] = self._validation
        return bar

    def show_validation(self, fraction: float) -> None:
        """Show how much of one of the two runs with the fresh seed is done."""
        self._validation.show((self._validated + fraction) / 2)
        self._validated += fraction >= 1.0

    def notice(self, sentence: str) -> None:
        """Print a sentence about something that delays the search."""
        if not self._quiet:
            self._print(sentence, err=True)

    def interrupted(self) -> None:
        """Say what is kept."""
        if not self._quiet:
            click.echo(
                f"Stopped after {self.ended} candidates. {self._task.history_path} has them: "
                "repeat the command with --resume to go on.",
                err=True,
            )

    def finish(self, search: Search, validation: Validation | None) -> None:
        """Print the result."""
        click.echo()
        for line in (*self._result(search), *_fresh(validation), *_failures(search)):
            click.echo(printable_text(line))
        if search.best():
            command = f"seamark run {self._task.benchmark.name}"
            controller = f"--controller {self._task.controller}"
            click.echo(f"\nBest configuration: {self._task.options.out}, for example")
            click.echo(f"  {command} {controller} --config {self._task.options.out}")
        click.echo(f"History: {self._task.history_path}")

    def document(self, search: Search, validation: Validation | None) -> dict[str, Any]:
        """Return the result as JSON values."""
        best = search.best()
        return {
            "benchmark": self._task.benchmark.name,
            "controller": self._task.controller,
            "method": self._task.options.method,
            "seed": self._task.options.seed,
            "trials": self._task.options.trials,
            "server": self._task.options.server,
            "best": _json(*best) if best else None,
            "validation": validation.to_json() if validation else None,
            "candidates": [_json(*pair) for _, pair in sorted(search.ended.items())],
            "out": str(self._task.options.out) if best else None,
            "history": str(self._task.history_path),
        }

    def _new_bar(self) -> AbstractContextManager[Any]:
        from rich.console import Console
        from rich.progress import (
            BarColumn,
            MofNCompleteColumn,
            Progress,
            TextColumn,
            TimeElapsedColumn,
            TimeRemainingColumn,
        )

        console = Console()
        if not console.is_terminal:
            return nullcontext()
        bar = Progress(
            TextColumn("candidates"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeElapsedColumn(),
            TextColumn("left"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
        )
        bar.add_task("", total=self._task.options.candidates + 1)
        return bar

    def _head(self) -> list[str]:
        task, options = self._task, self._task.options
        names = "".join(f"  {name[-_VALUE:]:>{_VALUE}}" for name in task.names[:_SHOWN])
        where = f"on {options.server}" if options.server else f"{task.jobs} at a time"
        return [
            f"{task.benchmark.name}, {task.controller}: {options.candidates} candidates by "
            f"{options.method}, {options.trials} trials each, seed {options.seed}, {where}",
            f"{'#':>{_NUMBER}}{names}  {'score':>{_SCORE}}",
        ]

    def _line(self, candidate: Candidate, evaluated: Evaluated, *, better: bool) -> str:
        texts = [_value(candidate.values[name]) for name in self._task.names[:_SHOWN]]
        values = "".join(f"  {text[:_VALUE]:>{_VALUE}}" for text in texts)
        score = "-" if evaluated.score is None else f"{evaluated.score:.4g}"
        notes = ["defaults"] if candidate.number == DEFAULTS else []
        notes += ["best so far"] if better and candidate.number != DEFAULTS else []
        notes += [f"failed: {evaluated.failure}"] if evaluated.failure else []
        note = ", ".join(notes)[:_NOTE]
        return f"{candidate.number:>{_NUMBER}}{values}  {score:>{_SCORE}}  {note}".rstrip()

    def _result(self, search: Search) -> list[str]:
        best = search.best()
        if best is None:
            return [f"None of {len(search.ended)} candidates has a score."]
        candidate, evaluated = best
        values = ", ".join(f"{name} {_value(value)}" for name, value in candidate.values.items())
        lines = [f"Best: candidate {candidate.number} with {values}: score {evaluated.score:.4g}"]
        defaults = search.ended[DEFAULTS][1].score
        if candidate.number == DEFAULTS:
            lines.append("No candidate was better than the defaults.")
        elif defaults is not None:
            lines.append(f"Defaults on the same trials: {defaults:.4g}")
        return lines


def _value(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _fresh(validation: Validation | None) -> list[str]:
    if validation is None:
        return []
    lines = [f"{validation.trials} fresh trials with seed {validation.seed}:"]
    if validation.best is not None and validation.defaults is not None:
        lines.append(f"  best {validation.best:.4g}, defaults {validation.defaults:.4g}")
    if validation.low is not None:
        lines.append(
            f"  difference {validation.difference:+.4g}, 95 % interval {validation.low:+.4g} to "
            f"{validation.high:+.4g}, paired"
        )
    return [*lines, f"  {validation.sentence()}"]


def _failures(search: Search) -> list[str]:
    failed = search.failed()
    if not failed:
        return []
    count = "1 candidate" if len(failed) == 1 else f"{len(failed)} candidates"
    lines = [f"{count} failed:"]
    lines += [f"  {one.number}: {how.failure}" for one, how in failed[:_FAILURES_SHOWN]]
    return lines + (["  ... (all are in the history)"] if len(failed) > _FAILURES_SHOWN else [])


def _json(candidate: Candidate, evaluated: Evaluated) -> dict[str, Any]:
    return {
        "candidate": candidate.number,
        "values": dict(candidate.values),
        "score": evaluated.score,
        "failure": evaluated.failure,
    }

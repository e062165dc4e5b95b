"""What both kinds of runs and sweeps show of their documents."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

from seamark.client.documents import RunDocument, RunState, SweepDocument
from seamark.client.watch import run_ended, sweep_ended
from seamark.drafts import draft_of
from seamark.progress import Progress
from seamark.sandbox.printable_text import printable_text


@contextmanager
def written_to(file: str | Path | BinaryIO) -> Iterator[BinaryIO]:
    """Provide a file to write to: a draft of the one at a path, or an open one as it is."""
    if isinstance(file, str | Path):
        with draft_of(file) as draft:
            yield draft
    else:
        yield file


class RunView:
    """A run as the server last described it; `document` has everything.

    Attributes
    ----------
    document : dict
        The document of the API (`GET /runs/<id>`).
    """

    def __init__(self, server: str, document: RunDocument) -> None:
        self.document = document
        self._server = server

    @property
    def id(self) -> int:
        """The number of the run."""
        return self.document["id"]

    @property
    def state(self) -> RunState:
        """`queued`, `running`, `succeeded`, `failed` or `cancelled`."""
        return self.document["state"]

    @property
    def ended(self) -> bool:
        """Whether the run has ended, however it did."""
        return run_ended(self.document)

    @property
    def progress(self) -> float:
        """How much of the run is done, 0 to 1."""
        return self.document["progress"]

    @property
    def score(self) -> float | None:
        """The score; None while there is none."""
        score: float | None = self._result("score")
        return score

    @property
    def score_interval(self) -> tuple[float, float] | None:
        """The 95 % interval of the score; None while there is none."""
        low, high = self._result("score_low"), self._result("score_high")
        return None if low is None or high is None else (low, high)

    @property
    def digest(self) -> str | None:
        """SHA-256 of the telemetry, which every computer reproduces; None while there is none."""
        digest: str | None = self._result("digest")
        return digest

    @property
    def failure(self) -> dict[str, Any] | None:
        """Why the run failed: `cause`, `sentence`, `remedy` and more; None if it did not."""
        return self.document["failure"]

    @property
    def public(self) -> bool:
        """Whether everybody can see the run."""
        return self.document["public"]

    @property
    def page(self) -> str:
        """The address of the run's page."""
        return self._server + self.document["links"]["page"]

    @property
    def heading(self) -> str:
        """What stands above its plot: number, title or benchmark, and score."""
        name = printable_text(self.document["title"]) or self.document["benchmark"]
        score = "" if self.score is None else f", score {self.score:.4g}"
        return f"Run {self.id}: {name}{score}"

    def _progress(self, *, quiet: bool) -> Progress:
        return Progress(f"run {self.id}", quiet=quiet)

    def _show(self, progress: Progress) -> None:
        position = self.document["position"]
        note = f"queued, position {position}" if position else printable_text(self.state)
        progress.show(self.progress, note, state=note)

    def _result(self, name: str) -> Any:
        return (self.document["result"] or {}).get(name)

    def __repr__(self) -> str:
        """Return the number, the benchmark, the state and the score."""
        score = "" if self.score is None else f", score {self.score:.4g}"
        return f"<run {self.id} of {self.document['benchmark']}: {self.state}{score}>"


class SweepView:
    """A sweep as the server last described it; `document` has everything."""

    def __init__(self, server: str, document: SweepDocument) -> None:
        self.document = document
        self._server = server

    @property
    def id(self) -> int:
        """The number of the sweep."""
        return self.document["id"]

    @property
    def ended(self) -> bool:
        """Whether all of its runs have ended."""
        return sweep_ended(self.document)

    @property
    def page(self) -> str:
        """The address of the sweep's page."""
        return self._server + self.document["links"]["page"]

    def _documents(self) -> list[RunDocument]:
        return [cell["run"] for cell in self.document["cells"] if cell["run"] is not None]

    def _progress(self, *, quiet: bool) -> Progress:
        return Progress(f"sweep {self.id}", quiet=quiet)

    def _show(self, progress: Progress) -> None:
        runs = self._documents()
        done = sum(1.0 if run_ended(run) else run["progress"] for run in runs)
        note = f"{len(runs) - self.document['live']} of {len(runs)} runs have ended"
        progress.show(done / len(runs) if runs else 1.0, note, state=note)

    def __repr__(self) -> str:
        """Return the number and how many runs there are."""
        cells, live = len(self.document["cells"]), self.document["live"]
        return f"<sweep {self.id}: {cells - live} of {cells} runs have ended>"

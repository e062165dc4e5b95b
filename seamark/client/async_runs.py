"""A run and a sweep of the client for asyncio."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO, Literal, overload

from typing_extensions import Self

from seamark.client import plots, tables
from seamark.client.documents import PublicationTerms, RunDocument, SweepDocument
from seamark.client.run_view import RunView, SweepView, written_to
from seamark.client.sessions import AsyncSession
from seamark.client.watch import watch_run, watch_sweep

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


class AsyncRun(RunView):
    """A run on a server. Its properties are those of the last answer; `refresh` asks again."""

    def __init__(self, session: AsyncSession, document: RunDocument) -> None:
        super().__init__(session.server, document)
        self._session, self._calls = session, session.calls

    async def refresh(self) -> Self:
        """Ask the server for the present state."""
        self.document = await self._session.do(self._calls.run(self.id))
        return self

    async def follow(self, *, timeout_s: float | None = None) -> AsyncIterator[Self]:
        """Yield the run at once and each time it has changed, until it has ended.

        Raises
        ------
        StillRunning
            After `timeout_s`, if it is not None.
        """
        watch = watch_run(self._calls, self.id, timeout_s=timeout_s)
        while (document := await self._session.do(watch.next_change())) is not None:
            self.document = document
            yield self

    async def wait(
        self,
        *,
        timeout_s: float | None = None,
        progress: bool = False,
        on_change: Callable[[AsyncRun], object] | None = None,
    ) -> Self:
        """Return the run once it has ended, however it did.

        With `progress`, shows a bar on a terminal, or lines in a pipe, on standard error.
        `on_change` is called with the run each time it has changed.

        Raises
        ------
        StillRunning
            After `timeout_s`, if it is not None.
        """
        with self._progress(quiet=not progress) as bar:
            async for run in self.follow(timeout_s=timeout_s):
                self._show(bar)
                if on_change is not None:
                    on_change(run)
        return self

    @overload
    async def telemetry(self, kind: Literal["numpy"] = "numpy") -> NDArray[np.void]: ...
    @overload
    async def telemetry(self, kind: Literal["pandas", "polars", "arrow"]) -> Any: ...
    async def telemetry(self, kind: tables.TableKind = "numpy") -> Any:
        """Return all rows so far, one per control step; also while the run is under way.

        A structured NumPy array (`rows["distance"]` is a column), or a data frame of `pandas` or
        `polars`, or an `arrow` table, where these are installed.
        """
        return tables.table(kind, *await self._session.do(self._calls.telemetry(self.id)))

    async def download(self, kind: str, file: str | Path | BinaryIO) -> None:
        """Write the run as `csv`, `parquet`, `mcap`, `npz`, `mat` or `archive` into a file.

        `file` is a path, or a file that is open for writing and can be positioned. Rows are
        those so far while the run is under way.
        """
        with written_to(file) as into:
            await self._session.do(self._calls.download(self.id, kind, into))

    async def plot(self, *, trial: int = 1) -> Figure:
        """Return what `seamark plot` draws of a trial; needs Matplotlib."""
        rows = await self.telemetry()
        return plots.figure(self.document, rows, title=self.heading, trial=trial)

    async def metrics(self) -> dict[str, Any]:
        """Return the metrics; raises NotFound while there are none."""
        document: dict[str, Any] = await self._session.do(self._calls.file(self.id, "metrics.json"))
        return document

    async def manifest(self) -> dict[str, Any]:
        """Return versions, configuration, seeds and digest; raises NotFound before the end."""
        document: dict[str, Any] = await self._session.do(
            self._calls.file(self.id, "manifest.json")
        )
        return document

    async def log(self) -> str:
        """Return what the program has printed so far, without the middle of very long output."""
        return await self._session.do(self._calls.text(self.id, "log"))

    async def program(self) -> bytes:
        """Return the uploaded program; raises NotFound if there is none."""
        return await self._session.do(self._calls.data(self.id, "program"))

    async def vehicle(self) -> bytes:
        """Return the file of the run's own vehicle; raises NotFound if it has another one."""
        return await self._session.do(self._calls.data(self.id, "vehicle.toml"))

    async def publish(
        self,
        method: str = "",
        *,
        program: bool = True,
        licence: str | None = None,
        anonymous: bool = False,
    ) -> Self:
        """Make the run public; a ranked one enters the leaderboard.

        Parameters
        ----------
        method
            What leaderboards, badges and citations call the run. Required for an uploaded program;
            without it, a built-in solution has its label.
        program
            With the uploaded program and its log; else the results only.
        licence
            Of the program: an SPDX identifier of the list that the form has.
        anonymous
            For review: nobody sees whose run it is.
        """
        terms: PublicationTerms = {
            "method": method,
            "program": program,
            "licence": licence,
            "anonymous": anonymous,
        }
        return await self._act("publish", terms)

    async def withdraw(self) -> Self:
        """Make the run private again and take it off the leaderboard."""
        return await self._act("withdraw")

    async def cancel(self) -> Self:
        """Cancel the run; what it recorded so far is kept."""
        return await self._act("cancel")

    async def _act(self, action: str, body: Mapping[str, object] | None = None) -> Self:
        self.document = await self._session.do(self._calls.act(self.id, action, body))
        return self


class AsyncSweep(SweepView):
    """A sweep on a server. Its properties are those of the last answer."""

    def __init__(self, session: AsyncSession, document: SweepDocument) -> None:
        super().__init__(session.server, document)
        self._session, self._calls = session, session.calls

    @property
    def runs(self) -> list[AsyncRun]:
        """The runs, in the order of the combinations; those that were deleted are missing."""
        return [AsyncRun(self._session, document) for document in self._documents()]

    @property
    def best(self) -> AsyncRun | None:
        """The run with the highest score so far."""
        return next((run for run in self.runs if run.id == self.document["best"]), None)

    async def wait(self, *, timeout_s: float | None = None, progress: bool = False) -> Self:
        """Return the sweep once all of its runs have ended; as `AsyncRun.wait`."""
        watch = watch_sweep(self._calls, self.id, timeout_s=timeout_s)
        with self._progress(quiet=not progress) as bar:
            while (document := await self._session.do(watch.next_change())) is not None:
                self.document = document
                self._show(bar)
        return self

    async def cancel(self) -> Self:
        """Cancel the runs that have not ended."""
        self.document = await self._session.do(self._calls.cancel_sweep(self.id))
        return self

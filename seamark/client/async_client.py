"""The client for asyncio; the calls themselves are those of `Client`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Literal

import httpx
from typing_extensions import Self, Unpack

from seamark.client.async_runs import AsyncRun, AsyncSweep
from seamark.client.documents import (
    BenchmarkDocument,
    CompareQuery,
    ComparisonDocument,
    LeaderboardDocument,
    LeaderboardQuery,
    RunsQuery,
    SubmissionOptions,
    Values,
)
from seamark.client.sessions import PATIENCE_S, AsyncSession


class AsyncClient:
    """A connection to one server; a context manager.

    Parameters
    ----------
    server
        Address of the server; SEAMARK_SERVER if omitted, else http://127.0.0.1:8000.
    token
        API token of an account; SEAMARK_TOKEN if omitted. Without one, a guest.
    patience_s
        How long the pauses between the attempts of one request may last in total [s]; 0 repeats
        nothing.
    transport
        Sends the requests instead of httpx's own.

    Examples
    --------
    >>> async with AsyncClient() as client:  # doctest: +SKIP
    ...     run = await client.submit("currents-v3", controller="pi")
    ...     await run.wait()
    """

    def __init__(
        self,
        server: str | None = None,
        token: str | None = None,
        *,
        patience_s: float = PATIENCE_S,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self._session = AsyncSession(server, token, patience_s=patience_s, transport=transport)
        self._calls = self._session.calls

    @property
    def server(self) -> str:
        """The address of the server."""
        return self._session.server

    def __repr__(self) -> str:
        """Return the address, never the token."""
        return f"<async client of {self.server}>"

    async def __aenter__(self) -> Self:
        """Return the client."""
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the connections."""
        await self.close()

    async def close(self) -> None:
        """Close the connections."""
        await self._session.close()

    async def submit(self, benchmark: str, **options: Unpack[SubmissionOptions]) -> AsyncRun:
        """Submit a run of the built-in `controller` or of the file `program`.

        `config` has settings by key; what is omitted has its default. With `kind="ranked"` the
        benchmark fixes the scenario, the seeds and the number of trials. `vehicle` is the file of
        a vehicle of your own, for practice runs.

        Raises
        ------
        ServerRefused, ServerUnavailable
        """
        return AsyncRun(
            self._session, await self._session.do(self._calls.submit(benchmark, options))
        )

    async def sweep(
        self, benchmark: str, axes: Mapping[str, Values], **options: Unpack[SubmissionOptions]
    ) -> AsyncSweep:
        """Start a run for each combination of values of one or two settings or parameters.

        `axes` has for each name a list of values, or a text such as "0.1:1.0:5".

        Raises
        ------
        ServerRefused, ServerUnavailable
        """
        document = await self._session.do(self._calls.sweep(benchmark, axes, options))
        return AsyncSweep(self._session, document)

    async def run(self, run_id: int) -> AsyncRun:
        """Return a run in its present state."""
        return AsyncRun(self._session, await self._session.do(self._calls.run(run_id)))

    async def find_sweep(self, sweep_id: int) -> AsyncSweep:
        """Return a sweep in its present state."""
        return AsyncSweep(self._session, await self._session.do(self._calls.show_sweep(sweep_id)))

    async def runs(
        self, *, limit: int | None = None, **query: Unpack[RunsQuery]
    ) -> AsyncIterator[AsyncRun]:
        """Yield runs, newest first, `limit` at most: one's own unless `which` says otherwise."""
        after: int | None = None
        while limit is None or limit > 0:
            page, after = await self._session.do(self._calls.runs_page(query, after, limit))
            for document in page:
                yield AsyncRun(self._session, document)
            limit = None if limit is None else limit - len(page)
            if after is None:
                return

    async def compare(
        self, run_ids: Sequence[int], **query: Unpack[CompareQuery]
    ) -> ComparisonDocument:
        """Return two to five runs side by side."""
        return await self._session.do(self._calls.compare(run_ids, query))

    async def leaderboard(
        self, benchmark: str, **query: Unpack[LeaderboardQuery]
    ) -> LeaderboardDocument:
        """Return a page of a leaderboard; `next` of a page is the `after` of the following one."""
        return await self._session.do(self._calls.leaderboard(benchmark, query))

    async def competitions(self) -> dict[str, Any]:
        """Return the competitions that are open or have ended, and the account's own drafts."""
        return await self._session.do(self._calls.competitions())

    async def competition(self, name: str) -> dict[str, Any]:
        """Return a competition with its rounds and its document."""
        return await self._session.do(self._calls.competition(name))

    async def create_competition(
        self,
        document: Mapping[str, Any],
        *,
        picture: str | Path | None = None,
        vehicle: str | Path | None = None,
        current_record: str | Path | None = None,
        target_texture: str | Path | None = None,
        replace: bool = False,
    ) -> dict[str, Any]:
        """Make a draft of a competition, or with `replace` change the draft of this name.

        The reference entries check it at once; see `competition_check`.

        Raises
        ------
        ServerRefused, ServerUnavailable
        OSError
            A file cannot be read.
        """
        files = {
            "picture": picture,
            "vehicle": vehicle,
            "current_record": current_record,
            "target_texture": target_texture,
        }
        call = self._calls.write_competition(document, files, replaces=replace)
        return await self._session.do(call)

    async def competition_check(self, name: str) -> dict[str, Any]:
        """Return how far the check of a competition is, and its report once it has ended."""
        return await self._session.do(self._calls.competition_check(name))

    async def open_competition(self, name: str) -> dict[str, Any]:
        """Open a draft whose check has ended; what it asks never changes from now on."""
        return await self._session.do(self._calls.change_competition(name, "open"))

    async def move_round(
        self, name: str, number: int, *, until: float, reason: str
    ) -> dict[str, Any]:
        """Move the end of a round, or the beginning of a final, to a time [s since 1970, UTC]."""
        body = {"until": until, "reason": reason}
        step = f"rounds/{number}/move"
        return await self._session.do(self._calls.change_competition(name, step, body))

    async def join_team(self, name: str, code: str) -> dict[str, Any]:
        """Join the team with a code, or the link to it, and agree on the competition's rules."""
        return await self._session.do(self._calls.join_team(name, code))

    async def competition_entries(self, name: str) -> dict[str, Any]:
        """Return what the account's team has submitted, and how much is left in this round."""
        return await self._session.do(self._calls.competition_entries(name))

    async def competition_board(
        self, name: str, number: int, *, per: Literal["team", "method"] = "team"
    ) -> dict[str, Any]:
        """Return the board of a round; of a hidden one the rows of the account's team."""
        return await self._session.do(self._calls.board(name, number, per))

    async def benchmarks(self) -> list[BenchmarkDocument]:
        """Return all benchmarks of the server."""
        return await self._session.do(self._calls.benchmarks())

    async def benchmark(self, name: str) -> dict[str, Any]:
        """Return a benchmark with the JSON Schema of its settings."""
        return await self._session.do(self._calls.benchmark(name))

    async def account(self) -> dict[str, Any]:
        """Return the account of the token, with its scopes and its quota."""
        return await self._session.do(self._calls.account())

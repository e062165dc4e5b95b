"""Somebody who follows a run by its live events."""

import asyncio
import json
from dataclasses import dataclass, field
from typing import Any

from seamark.server.accounts.credentials import Credential
from seamark.server.web.streams.events import Position
from seamark.server.web.streams.hub import Hub

DEADLINE_S = 60.0


@dataclass
class Viewer:
    """Somebody who follows a run, and what he has received."""

    hub: Hub
    run_id: int
    after: str = ""
    shows_log: bool = True
    credential: Credential | None = None
    pieces: list[bytes] = field(default_factory=list)
    aborted: bool = False

    async def watch(self) -> None:
        """Receive events until the stream ends."""
        self.gone: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        async for piece in self.hub.follow(
            self.run_id,
            Position.parse(self.after),
            shows_log=self.shows_log,
            credential=self.credential,
            gone=self.gone,
            abort=self.abort,
        ):
            self.pieces.append(piece)

    def abort(self) -> None:
        self.aborted = True
        self.gone.set_result(None)

    def events(self, event_type: str) -> list[dict[str, Any]]:
        return [data for kind, _, data in parsed(b"".join(self.pieces)) if kind == event_type]

    def times(self) -> list[float]:
        """Return the simulated times of the rows."""
        batches = self.events("telemetry")
        return [row[batch["columns"].index("t")] for batch in batches for row in batch["rows"]]

    def log(self) -> str:
        return "".join(event["text"] for event in self.events("log"))

    @property
    def last_id(self) -> str:
        return [event_id for _, event_id, _ in parsed(b"".join(self.pieces)) if event_id][-1]

    async def receives(self, event_type: str, count: int = 1) -> None:
        """Wait until so many events of a type have come."""
        async with asyncio.timeout(DEADLINE_S):
            while len(self.events(event_type)) < count:
                await asyncio.sleep(0.01)


def parsed(data: bytes) -> list[tuple[str, str, dict[str, Any]]]:
    """Return type, id and data of each event."""
    found = []
    for block in data.decode().split("\n\n"):
        fields = dict(line.split(": ", 1) for line in block.splitlines() if not line[0] == ":")
        if "event" in fields:
            found.append((fields["event"], fields.get("id", ""), json.loads(fields["data"])))
    return found

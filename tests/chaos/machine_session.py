"""The stores of the service on the first of two machines, and containers on both.

Everything is read from the Compose files but for PostgreSQL's first start, which its image adds,
and an S3 server in the place of Garage.
"""

import ctypes
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
from redis import Redis
from redis.exceptions import RedisError

from seamark.embedded.broker import find_server
from seamark.sim.numerics.numba_internals import numba_folder
from tests.chaos.containers import Container, Host, Machine
from tests.services import compose, postgres
from tests.services.faulty_s3 import FaultyS3, in_front_of
from tests.worker.conftest import wait_until

HERE, ELSEWHERE = Machine("sea-a", "10.77.0"), Machine("sea-b", "10.77.1")
STORES = {"redis": "10.77.0.2", "postgres": "10.77.0.3", "objects": "10.77.0.4"}
PROXY = "10.77.0.1"  # this process, in front of the S3 server
START_S = 300.0
QUOTAS = {"SEAMARK_QUOTA_LIVE": "1000", "SEAMARK_QUOTA_DAY": "10000", "SEAMARK_RANKED_DAY": "100"}
FIRST_START = """
set -e
cd /tmp
mkdir -p /var/lib/postgresql/data/cluster
initdb -D /var/lib/postgresql/data/cluster -U postgres --no-sync --encoding=UTF8 \
    --auth-local=trust --auth-host=scram-sha-256 --pwfile="$POSTGRES_PASSWORD_FILE"
echo 'host all all all scram-sha-256' >> /var/lib/postgresql/data/cluster/pg_hba.conf
pg_ctl -D /var/lib/postgresql/data/cluster -o '-c listen_addresses= -k /var/run/postgresql' -w start
export POSTGRES_USER=postgres
createdb -U postgres "$POSTGRES_DB"
sh {roles}
pg_ctl -D /var/lib/postgresql/data/cluster -m fast -w stop
exec postgres -D /var/lib/postgresql/data/cluster -c listen_addresses='*' -k /var/run/postgresql
"""


class Session:
    """The service on both machines."""

    def __init__(self, host: Host, objects: FaultyS3) -> None:
        self.host, self.objects = host, objects
        self._numbers = iter(range(10, 250))
        self.running: dict[str, Container] = {}
        self.wrong: list[str] = []

    def saw(self, what: str, holds: object) -> None:
        """Print what was seen, or remember that it was not."""
        print(f"{'ok   ' if holds else 'WRONG'} {what}", flush=True)
        if not holds:
            self.wrong.append(what)

    def start(
        self,
        service: str,
        machine: Machine = HERE,
        *,
        name: str = "",
        number: int = 0,
        changed: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> Container:
        """Start a container of a service of compose.yaml, or of compose.worker.yaml elsewhere."""
        file = "compose.yaml" if machine is HERE else "compose.worker.yaml"
        words = compose.service(service, file) | dict(changed or {})
        name = name or service
        number = number or next(self._numbers)
        self.running[name] = Container(self.host, machine, number, words, name=name, **options)
        return self.running[name]

    def step(self, service: str, command: list[str] | None = None) -> str:
        """Run a step to its end; return what it printed."""
        name = service if command is None else "command"
        step = self.start(service, name=name, command=command or (), environment=QUOTAS)
        code = step.wait(START_S)
        del self.running[name]
        printed = step.log.read_text()
        if command is None:
            self.saw(f"{service} ends with 0", code == 0)
        if code:
            raise RuntimeError(printed)
        return printed

    def url(self, secret: str) -> str:
        """Return the URL in a secret, with the address of the store in the place of its name."""
        text = (self.host.secrets / secret).read_text()
        for name, address in STORES.items():
            text = re.sub(rf"@{name}\b", f"@{address}", text)
        return text

    def stop(self) -> None:
        """Stop everything, the stores last."""
        for name in sorted(self.running, key=lambda name: name in STORES):
            self.running[name].stop(within_s=20.0)


def _start_stores(session: Session) -> None:
    binaries = postgres.binaries()
    assert binaries is not None
    inside = {"PGHOST": "/var/run/postgresql"}
    inside |= {"PATH": f"{binaries}:{Path(sys.executable).parent}:/usr/bin:/bin:/usr/sbin:/sbin"}
    roles = compose.ROOT / "deploy" / "postgres" / "roles.sh"
    first_start = ["sh", "-c", FIRST_START.replace("{roles}", str(roles))]
    valkey = {"PATH": f"{find_server().parent}:/usr/bin:/bin"}
    numbers = {name: int(address.rpartition(".")[2]) for name, address in STORES.items()}
    session.start("redis", number=numbers["redis"], environment=valkey)
    session.start("postgres", number=numbers["postgres"], command=first_start, environment=inside)
    session.start("objects", number=numbers["objects"], command=_s3_server())
    # The package with the server has no valkey-cli, which the health check of redis calls.
    with Redis.from_url(session.url("broker_url")) as client:
        wait_until(lambda: _answers_ping(client), START_S)
    wait_until(session.running["postgres"].is_healthy, START_S)
    wait_until(_has_bucket, START_S)
    session.saw("PostgreSQL, Valkey with its password and the S3 server answer", True)


def _answers_ping(client: Redis) -> bool:
    try:
        return bool(client.ping())
    except RedisError:
        return False


def _has_bucket() -> bool:
    try:
        return httpx.put(f"http://{STORES['objects']}:3900/seamark").is_success
    except httpx.TransportError:
        return False


def _s3_server() -> list[str]:
    address = STORES["objects"]
    return [sys.executable, "-m", "moto.server", "--host", address, "--port", "3900"]


@contextmanager
def started(steps: Sequence[str]) -> Iterator[Session]:
    """Yield a session whose stores run, after some steps; this process is in its network then."""
    _own_namespaces()
    with tempfile.TemporaryDirectory(prefix="machines") as folder:
        host = Host.create(Path(folder), numba_folder(os.environ), (HERE, ELSEWHERE))
        host.names(STORES | {"objects": PROXY})
        with in_front_of(f"http://{STORES['objects']}:3900", (PROXY, 3900)) as objects:
            session = Session(host, objects)
            try:
                _start_stores(session)
                for step in steps:
                    session.step(step)
                yield session
            finally:
                session.stop()


def _own_namespaces() -> None:
    """Continue in a network and a mount namespace of this session."""
    if os.geteuid() != 0:
        sys.exit("The session makes namespaces: run it as root.")
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(0x40000000 | 0x00020000) != 0:  # CLONE_NEWNET | CLONE_NEWNS
        sys.exit(f"No namespaces: {os.strerror(ctypes.get_errno())}.")
    subprocess.run(["mount", "--make-rprivate", "/"], check=True)

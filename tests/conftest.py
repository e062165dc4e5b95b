"""Fixtures that several packages share: real databases, a real broker, the cast."""

import gc
import signal
import sys
import uuid
from collections.abc import Iterator
from pathlib import Path

import pytest
import structlog
from argon2 import PasswordHasher
from execnet import XSpec
from hypothesis import HealthCheck
from hypothesis import settings as hypothesis_settings
from redis import Redis

from seamark.cli.main import GARBAGE_AFTER
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.probing.probes import probe
from seamark.server.accounts import accounts
from seamark.server.database.engine import Database
from seamark.server.monitoring import meters
from seamark.server.settings import Settings
from seamark.sim import vehicles
from seamark.sim.settings.own_files import LIBRARIES
from seamark.sim.vehicles import own
from tests.cast import Backend
from tests.services import (
    compiled_once,
    forked_commands,
    forked_processes,
    forked_workers,
    postgres,
    s3,
    scratch,
    tables,
    uploads,
    valkey,
)
from tests.services.late_compilation import LateCompilation

# A shell that starts the tests in the background makes them, and what they start, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
# Not to what a command under test prints.
structlog.configure(logger_factory=lambda *_: structlog.PrintLogger(sys.__stderr__))
# A busy machine fails no property.
hypothesis_settings.register_profile(
    "patient",
    hypothesis_settings(),  # on a server for tests: repeatable
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
hypothesis_settings.load_profile("patient")
compiled_once.share()
uploads.read_without_spare()
forked_commands.share()
scratch.use_memory()
# Hashing a password is dear on purpose; only tests of that hash as the service does.
QUICK_HASHER = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
HASHER_OF_SERVICE, accounts._hasher = accounts._hasher, QUICK_HASHER
# A full collection looks at 800,000 objects, for a second: it took a third of some files' time, and
# what is loaded to collect the tests is hardly ever garbage.
gc.set_threshold(GARBAGE_AFTER)
gc.disable()
LATE = LateCompilation()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add what `./run fuzz-api` and `./run test` pass on."""
    parser.addoption(
        "--api-cases", type=int, default=768, help="requests to the API on each database"
    )
    parser.addoption(
        "--list-late-compilation",
        action="store_true",
        help="list what was compiled although `tests.precompile` came before",
    )


def pytest_xdist_setupnodes(config: pytest.Config, specs: list[XSpec]) -> None:
    """Let the processes of the tests begin with what is loaded here, once for all."""
    forked_workers.prepare()
    forked_processes.start(config, specs)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List what `tests.precompile` lacks: several processes may have compiled it at a time."""
    if terminalreporter.config.getoption("--list-late-compilation") and (late := LATE.functions()):
        terminalreporter.section(f"{len(late)} compiled late: tests/precompile.py lacks them")
        terminalreporter.write_line(", ".join(late))


NEEDS = {  # fixture -> mark of the tests that use it
    "chromium": pytest.mark.browser,
    "isolation": pytest.mark.host,
    "_postgres": pytest.mark.host,  # root starts it in a user namespace
    "simulator": pytest.mark.slow,
    "running": pytest.mark.slow,
}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests by what their fixtures need, so that `./run test --quick` leaves them out."""
    for item in items:
        for fixture in NEEDS.keys() & set(getattr(item, "fixturenames", ())):
            item.add_marker(NEEDS[fixture])


def pytest_collection_finish() -> None:
    """Keep what is loaded and collected, which stays to the end, from the garbage collector."""
    gc.freeze()
    gc.enable()


@pytest.fixture(autouse=True)
def _own_files_of_this_test() -> Iterator[None]:
    """What a test adds is not there for the next: commands run in the process of the tests."""
    yield
    vehicles.added.clear()
    own._FILES.clear()
    for library in LIBRARIES.values():
        library._added.clear()


@pytest.fixture(scope="session")
def isolation() -> IsolationLevel:
    """The isolation level of boxes on this machine; without boxes the test is skipped."""
    report = probe()
    if report.level < IsolationLevel.MEDIUM:
        pytest.skip(report.sentence())
    return report.level


@pytest.fixture(scope="session")
def _valkey() -> Iterator[str]:
    with valkey.on_socket() as url:
        yield url


@pytest.fixture(scope="session")
def _valkey_client(_valkey: str) -> Iterator[Redis]:
    with Redis.from_url(_valkey) as client:
        yield client


@pytest.fixture
def redis_url(_valkey: str, _valkey_client: Redis) -> Iterator[str]:
    """The unix:// URL of an empty broker."""
    yield _valkey
    _valkey_client.flushall()


@pytest.fixture(scope="session")
def redis_tcp_url() -> Iterator[str]:
    """The redis:// URL of a broker on the loopback interface."""
    with valkey.on_port() as url:
        yield url


@pytest.fixture(scope="session")
def s3_server() -> Iterator[s3.Server]:
    """An S3 server with one bucket."""
    with s3.server() as server:
        yield server


@pytest.fixture
def database_url(tmp_path: Path) -> str:
    """The URL of an SQLite database without tables."""
    return f"sqlite:///{tmp_path / 'seamark.db'}"


@pytest.fixture(scope="session")
def _postgres() -> Iterator[str]:
    if reason := postgres.reason_unavailable():
        pytest.skip(reason)
    with postgres.server() as server:
        yield server.folder


@pytest.fixture
def postgres_url(_postgres: str) -> Iterator[str]:
    """The URL of a PostgreSQL database without tables."""
    with postgres.database(_postgres, f"t{uuid.uuid4().hex}") as url:
        yield url


@pytest.fixture(scope="session")
def _postgres_tables(_postgres: str) -> Iterator[str]:
    with postgres.database(_postgres, "tables") as url:
        tables.migrate(url)
        yield "tables"


@pytest.fixture
def postgres_tables_url(_postgres: str, _postgres_tables: str) -> Iterator[str]:
    """The URL of a PostgreSQL database with tables, for `tables.adopt`."""
    name = f"t{uuid.uuid4().hex}"
    with postgres.database(_postgres, name, template=_postgres_tables) as url:
        yield url


@pytest.fixture
def other_postgres_url(_postgres: str) -> Iterator[str]:
    """The URL of one more PostgreSQL database without tables."""
    with postgres.database(_postgres, f"t{uuid.uuid4().hex}") as url:
        yield url


@pytest.fixture
def settings(tmp_path: Path, database_url: str, redis_url: str) -> Settings:
    """Settings of a service with its own data folder, database and broker."""
    # Or each service would look through the routes of all before it.
    for counted in (meters.HTTP_REQUESTS, meters.HTTP_SECONDS):
        counted.clear()
    return Settings.model_validate(
        {
            "data": tmp_path / "data",
            "database_url": database_url,
            "broker_url": redis_url,
            "secret_key": "only-for-tests",
            "workers": 1,
            "ranked_day": 1000,
        }
    )


@pytest.fixture
def database(settings: Settings) -> Iterator[Database]:
    """The SQLite database of `settings`, with tables."""
    opened = tables.create(settings)
    yield opened
    opened.close()


@pytest.fixture
def backend(database: Database, settings: Settings) -> Backend:
    """The cast on the SQLite database of `settings`."""
    return Backend.with_cast(database, settings)

"""`seamark doctor`: what works on this machine, and how to fix what does not."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.extras import SERVER, install_line, missing
from seamark.cli.options import data_option, json_option, settings_of

if TYPE_CHECKING:
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.server.database.engine import Database
    from seamark.server.settings import Settings

DISK_LOW_GIB = 2.0
PACKAGES = ("numpy", "numba", "cv2", "scipy", "orjson", "pydantic", "httpx", "rich")


@dataclass(frozen=True, slots=True)
class Check:
    """A result: ok, warning (something works less well) or bad (something does not work)."""

    name: str
    state: str  # "ok", "warning", "bad"
    says: str
    remedy: str = ""


@click.command()
@data_option
@json_option
def doctor(data: Path | None, as_json: bool) -> None:
    """Check this machine and say how to fix what is missing.

    Exit code 0: runs and uploads work; 3: something does not.

    \b
    Examples:
      seamark doctor
      seamark doctor --json
    """
    settings = None if missing(SERVER) else settings_of(data)
    checks = [check for probe in PROBES for check in probe(settings)]
    bad = any(check.state == "bad" for check in checks)
    if as_json:
        print_json({"good": not bad, "checks": [asdict(check) for check in checks]})
        exit_with(3 if bad else 0)
    colours = {"ok": "green", "warning": "yellow", "bad": "red"}
    for check in checks:
        mark = click.style(f"{check.state:<7}", fg=colours[check.state])
        click.echo(f"{mark} {check.name}: {check.says}")
        if check.remedy and check.state != "ok":
            click.echo(f"        -> {check.remedy}")
    click.echo("")
    click.echo("Something does not work; see above." if bad else "Runs and uploads work here.")
    exit_with(3 if bad else 0)


def _python(_: Settings | None) -> Iterable[Check]:
    yield Check("python", "ok", f"{sys.version.split()[0]}, {sys.executable}")


def _packages(_: Settings | None) -> Iterable[Check]:
    lacking = missing(PACKAGES)
    yield Check(
        "packages",
        "bad" if lacking else "ok",
        f"missing: {', '.join(lacking)}" if lacking else "all installed",
        "Install Seamark again; in a checkout, `./run` does that.",
    )
    yield from _opencv()
    without = missing(("pybullet",))
    yield Check(
        "contacts",
        "warning" if without else "ok",
        "off: PyBullet is not installed" if without else "computed by PyBullet",
        "Use Python 3.11: PyBullet has wheels for no other version.",
    )


def _opencv() -> Iterable[Check]:
    if missing(("cv2",)):
        return
    from seamark.sim.recording.opencv import complaint, running

    says = complaint()
    yield Check("opencv", "warning" if says else "ok", says or running())


def _service(settings: Settings | None) -> Iterable[Check]:
    if settings is None:
        says = f"not installed; only a service needs more: {install_line('server')}"
        yield Check("server", "ok", says)
        return
    yield from _database(settings)
    yield from _broker(settings)


def _database(settings: Settings) -> Iterable[Check]:
    from sqlalchemy import make_url
    from sqlalchemy.exc import SQLAlchemyError

    from seamark.server.database import schema
    from seamark.server.database.connecting import DatabaseAway
    from seamark.server.database.engine import Database

    url = make_url(settings.database_url)
    shown = url.render_as_string(hide_password=True)
    file = Path(url.database) if url.drivername.startswith("sqlite") and url.database else None
    if file is not None and not file.exists():
        yield Check("database", "ok", f"{shown} (created at the first start)")
        return
    database = Database(settings.database_url)
    try:
        schema.check(database.engine)
        yield Check("database", "ok", shown)
        if database.engine.dialect.name == "postgresql":
            yield _limits(database)
    except schema.SchemaTooOld as old:
        yield Check("database", "warning", str(old), "`seamark db upgrade` or `seamark up`")
    except (DatabaseAway, schema.SchemaTooNew) as failed:
        yield Check("database", "bad", str(failed))
    except SQLAlchemyError as error:
        remedy = "Check SEAMARK_DATABASE_URL and that the server is running."
        yield Check("database", "bad", f"{shown}: {type(error).__name__}", remedy)
    finally:
        database.close()


def _limits(database: Database) -> Check:
    """Say whether PostgreSQL ends the transactions of machines that vanish."""
    from seamark.server.database import session_limits

    name = "limits of sessions"
    with database.engine.connect() as connection:
        found = session_limits.find(connection)
    if not found.missing:
        return Check(name, "ok", "a machine that vanishes does not hold up the others")
    says = f"not in force: {', '.join(found.missing)}"
    if found.pooled:
        says = (
            f"a pooler stands before PostgreSQL, and its sessions lack {', '.join(found.missing)}"
        )
    remedy = (
        "A machine that vanishes may stop the queue for hours. Set them for the role of the "
        'service, see "A pooler before PostgreSQL" in docs/hosting.md.'
    )
    return Check(name, "warning", says, remedy)


def _broker(settings: Settings) -> Iterable[Check]:
    from redis.exceptions import RedisError

    from seamark.embedded.broker import find_server
    from seamark.failures import PlatformFailed
    from seamark.server.messaging import broker

    if not settings.broker_url:
        try:
            yield Check("broker", "ok", f"`seamark up` starts {find_server().name}")
        except PlatformFailed as missing:
            yield Check("broker", "bad", "none", str(missing))
        return
    client = broker.connect(settings)
    try:
        client.ping()
        yield Check("broker", "ok", "answers")
    except RedisError as error:
        remedy = "Check SEAMARK_BROKER_URL and that the server is running."
        yield Check("broker", "bad", f"does not answer: {error}", remedy)
    finally:
        client.close()


def _sandbox(settings: Settings | None) -> Iterable[Check]:
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing.probes import probe

    found = probe()
    least = settings.sandbox_min_level if settings else "medium"
    needed = IsolationLevel[least.upper()]
    name = found.level.name.lower()
    good = found.level >= needed and found.level > IsolationLevel.NONE
    says = f"level {name}; uploads need {least}"
    yield Check("isolation", "ok" if good else "bad", says, "See the findings below.")
    for finding in found.findings:
        state = "ok" if finding.ok else "warning"
        yield Check(f"  {finding.name}", state, finding.why or "ok", finding.remedy)
    if good:
        yield from _languages(found.level)


def _languages(isolation: IsolationLevel) -> Iterable[Check]:
    from seamark.sandbox.languages import LANGUAGES
    from seamark.sandbox.probing.self_test import tried

    for language in LANGUAGES.values():
        result = tried(language.name, isolation)
        components = ", ".join(f"{one.name} {one.version}" for one in result.contents)
        says = f"pass their self-test ({components})" if components else "pass their self-test"
        remedy = f"{language.remedy}; without it the other languages still run."
        name = f"programs in {language.label}"
        yield Check(name, "warning" if result.why_not else "ok", result.why_not or says, remedy)


def _visp(_: Settings | None) -> Iterable[Check]:
    from seamark.sim.trackers.visp.installation import (
        REMEDY,
        bridge_path,
        unavailable_reason,
    )

    why = unavailable_reason()
    yield Check("tracker visp", "warning" if why else "ok", why or bridge_path().name, f"{REMEDY}.")


def _machine(settings: Settings | None) -> Iterable[Check]:
    cores = len(os.sched_getaffinity(0))
    parallel = f"{settings.workers} runs" if settings else f"{cores} trials"
    yield Check("cores", "ok", f"{cores}, so {parallel} at the same time")
    folder = settings.data if settings else Path.cwd()
    free = shutil.disk_usage(folder).free / 2**30
    low = free < DISK_LOW_GIB
    yield Check(
        "disk",
        "warning" if low else "ok",
        f"{free:.1f} GiB free in {folder}",
        "A run of 600 s takes about 5 MB. Choose another folder with --data.",
    )


PROBES: tuple[Callable[[Settings | None], Iterable[Check]], ...] = (
    _python,
    _packages,
    _service,
    _sandbox,
    _visp,
    _machine,
)

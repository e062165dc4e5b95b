"""`seamark doctor`: what works on this machine, and how to fix what does not."""

from __future__ import annotations

import os
import shutil
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from seamark.cli.console import exit_with, print_json
from seamark.cli.extras import SERVER, install_line, missing
from seamark.cli.findings import Check
from seamark.cli.local_service import data_option, settings_of
from seamark.cli.options import json_option

if TYPE_CHECKING:
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.server.settings import Settings

DISK_LOW_GIB = 2.0
PACKAGES = ("numpy", "numba", "cv2", "scipy", "orjson", "pydantic", "httpx", "rich")


@click.command()
@data_option
@json_option
def doctor(data: Path | None, as_json: bool) -> None:
    """Check this machine and say how to fix what is missing.

    Of a service it looks at database, broker, storage, keys and free space, for some seconds, and
    writes nothing.

    Exit code 0: runs and uploads work, though what is a warning may be missing, such as a language;
    3: something that they need does not work.

    \b
    Examples:
      seamark doctor
      seamark doctor --json
    """
    settings = None if missing(SERVER) else settings_of(data, looking=True)
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
    from seamark.cli.service_checks import of_service

    yield from of_service(settings)


def _sandbox(settings: Settings | None) -> Iterable[Check]:
    from seamark.sandbox.isolation.level import IsolationLevel
    from seamark.sandbox.probing.probes import probe

    isolation = probe()
    least = settings.sandbox_min_level if settings else "medium"
    needed = IsolationLevel[least.upper()]
    name = isolation.level.name.lower()
    good = isolation.level >= needed and isolation.level > IsolationLevel.NONE
    says = f"level {name}; uploads need {least}"
    yield Check("isolation", "ok" if good else "bad", says, "See the findings below.")
    for finding in isolation.findings:
        state = "ok" if finding.ok else "warning"
        yield Check(f"  {finding.name}", state, finding.why or "ok", finding.remedy)
    if good:
        yield from _languages(isolation.level)


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
    if settings is not None:
        return  # a service needs the room that it is set to, see `service_checks`
    folder = Path.cwd()
    free = shutil.disk_usage(folder).free / 2**30
    low = free < DISK_LOW_GIB
    yield Check(
        "disk",
        "warning" if low else "ok",
        f"{free:.1f} GiB free in {folder}",
        "A run of 600 s takes about 5 MB. Work in another folder.",
    )


PROBES: tuple[Callable[[Settings | None], Iterable[Check]], ...] = (
    _python,
    _packages,
    _service,
    _sandbox,
    _visp,
    _machine,
)

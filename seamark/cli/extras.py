"""Packages that only a part of the commands needs, and how to install them."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import site
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import urljoin

import click

from seamark.failures import UsageRefused

# What `import` calls the packages of the extra in pyproject.toml that a service cannot do without.
SERVER = (
    *("alembic", "argon2", "authlib", "celery", "flask", "flask_limiter", "flask_login"),
    *("flask_openapi3", "flask_wtf", "gunicorn", "markdown_it", "mcap_ros2", "obstore"),
    *("prometheus_client", "psycopg", "pyarrow", "pygments", "redis", "requests"),
    *("rosbags", "sqlalchemy", "structlog", "svg", "uvicorn", "uvicorn_worker", "websockets"),
)


def has_simulator() -> bool:
    """Return whether the distribution `seamark` is here, or `seamark-client` alone."""
    return importlib.util.find_spec("seamark.sim") is not None


def without_simulator(what: str) -> UsageRefused:
    """Return the refusal of what needs the simulator, with how to install it (PEP 610)."""
    origin = importlib.metadata.distribution("seamark-client").read_text("direct_url.json")
    source = json.loads(origin) if origin else {}
    page = urljoin(source.get("url", ""), "/docs/install") if "archive_info" in source else ""
    how = f"{page} has the line to copy" if page.startswith("http") else "pip install seamark"
    return UsageRefused(f"{what} needs the simulator, which seamark-client is without: {how}.")


def need_simulator(what: str) -> None:
    """Raise UsageRefused if `seamark-client` is installed alone."""
    if not has_simulator():
        raise without_simulator(what)


def missing(packages: Iterable[str]) -> list[str]:
    """Return those packages that cannot be imported, without importing them."""
    return [name for name in packages if importlib.util.find_spec(name) is None]


def absent_in_box(sentence: str) -> str:
    """Return how to install what a program did not find, if servers have it; else nothing.

    Parameters
    ----------
    sentence
        Of the failure of a program that ran on this machine.
    """
    from seamark.sandbox.languages.python.host import OPTIONAL

    for name in missing(OPTIONAL):
        if f"ModuleNotFoundError: No module named '{name}" in sentence:
            return f"Servers have {name}. Here the extra `box` installs it: {install_line('box')}"
    return ""


def install_line(extra: str) -> str:
    """Return the command that adds an extra, to a wheel from where that came from (PEP 610)."""
    origin = importlib.metadata.distribution("seamark").read_text("direct_url.json")
    source = json.loads(origin) if origin else {}
    where = f" @ {source['url']}" if "archive_info" in source else ""
    return f'pip install "seamark[{extra}]{where}"'


def refuse_packages_of_the_user() -> None:
    """Raise UsageRefused if this is one of the user's own packages.

    The processes of a service start without them: whatever lies in a user's home is not its code.
    """
    if site.ENABLE_USER_SITE and Path(__file__).is_relative_to(site.getusersitepackages()):
        raise UsageRefused(
            "A service needs a virtual environment, pipx or uv: it does not see packages that "
            "`pip install --user` has installed."
        )


def refuse_without_server(command: click.Command) -> None:
    """Make a command and those below it say what to install, if it is not; --help still works."""
    if missing(SERVER):
        _refuse(command)


def _refuse(command: click.Command) -> None:
    if isinstance(command, click.Group):
        for below in command.commands.values():
            _refuse(below)
    else:
        command.callback = _say_what_to_install


def _say_what_to_install(**_: object) -> None:
    raise UsageRefused(
        "This command belongs to the service, which needs further packages on Python 3.11: "
        f"{install_line('server')}."
    )

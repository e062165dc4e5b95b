"""A service in a process of its own, with one more line in each registry; prints what it shows.

`python -m tests.additions.service FOLDER BROKER` prints a JSON object: address -> text of all pages
that an admin can open without a number or a name in their address, and of some that have one.
"""

# ruff: noqa: E402  (the lines of the registries come before everything that reads them)
import json
import sys
from pathlib import Path
from typing import Any

from seamark.sim import registry

THINGS = next(Path(folder) for folder in sys.path if Path(folder, "dory.toml").exists())
registry.BENCHMARKS["harbour-v1"] = "harbour_v1.definition:BENCHMARK"
registry.VEHICLES["dory"] = THINGS / "dory.toml"
registry.TRACKERS["drifter"] = "drifter:TRACKER"
registry.CONTROLLERS["ahead"] = "ahead:Controller"

from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import Language

FORMULAS: Language = __import__("formulas").FORMULAS
LANGUAGES[FORMULAS.name] = FORMULAS

from seamark.formats.registry import FORMATS, Format

FORMATS["knots"] = Format(
    name="knots",
    file="telemetry.knots",
    media_type="text/plain",
    label="for sailors, on a rope",
    module="knots",
    document="Download all rows so far as knots.",
)

from seamark.server.pages.administration import ADMIN_PAGES

ADMIN_PAGES.append(__import__("weather").WEATHER)

from click import Context
from flask import Flask

import seamark.gym
from seamark.cli.commands.export import export
from seamark.programs import preparation
from seamark.sandbox.languages import starters
from seamark.server.app import create_app
from seamark.server.database.engine import Database
from seamark.server.database.schema import upgrade
from seamark.server.database.tables import Worker
from seamark.server.messaging import workers
from seamark.server.settings import Settings
from seamark.server.web import authentication
from tests.cast import Backend

NAMED = (
    "/submit/harbour-v1",
    "/benchmarks/harbour-v1",
    "/leaderboards/harbour-v1",
    "/api/v1/benchmarks/harbour-v1",
    "/api/v1/leaderboards/harbour-v1",
    *(f"/docs/{name}" for name in ("box", "controller", "languages", "metrics", "physics")),
    "/docs/physics/dory.urdf",
    "/runs/{run}",
    "/api/v1/runs/{run}/scene.json",
)


def _register(backend: Backend) -> None:
    """Have a worker online that runs programs in all languages."""
    row = Worker(name="w1", slots=1, level="strong", languages=[*LANGUAGES], findings=[])
    row.contents = {name: [] for name in LANGUAGES}
    with backend.database.writing() as session:
        workers.register(session, row)


def _addresses(app: Flask, run_id: int) -> list[str]:
    rules = [rule for rule in app.url_map.iter_rules() if "GET" in (rule.methods or ())]
    plain = [rule.rule for rule in rules if not rule.arguments]
    return [*plain, *(path.format(run=run_id) for path in NAMED)]


def _shown(app: Flask, backend: Backend, addresses: list[str]) -> dict[str, str]:
    client = app.test_client()
    with app.app_context():
        cookie = authentication.cookie_of(backend.user_id("root"))
    with client.session_transaction() as session:
        session.update(cookie)
    found = {}
    for address in addresses:
        answer = client.get(address, follow_redirects=True)
        if answer.status_code == 200 and answer.content_type.startswith(("text/", "application/j")):
            found[address] = answer.text
    return found


def main(folder: str, broker: str) -> None:
    """Print what the service shows."""
    values = {"data": folder, "broker_url": broker, "secret_key": "only-for-tests", "workers": 1}
    settings = Settings.model_validate(values)
    upgrade(settings)
    database = Database(settings.database_url)
    backend = Backend.with_cast(database, settings)
    _register(backend)
    added: dict[str, Any] = {"benchmark": "harbour-v1", "controller": "ahead"}
    tracked = {"tracker": "drifter"}
    run_id = backend.published("ann", **added, config=tracked | {"vehicle": "dory"})
    backend.published("eva", **added, config=tracked, kind="ranked")
    program = backend.store_program(FORMULAS.starters[0].upload(), "mine.formulas")
    in_formulas: dict[str, Any] = {
        "benchmark": "harbour-v1",
        "controller": "upload",
        "program": program,
    }
    backend.queue("ann", **in_formulas)
    app = create_app(settings)
    app.testing = True
    found = _shown(app, backend, _addresses(app, run_id))
    found |= {"seamark export --help": export.get_help(Context(export))}
    found |= {"environments of Gymnasium": " ".join(seamark.gym.BENCHMARKS)}
    found |= {"weather for a guest": app.test_client().get("/admin/weather").text}
    found |= {
        "starters": " ".join(starters()),
        "parameters": " ".join(
            one.name
            for one in preparation.prepare(b"# @parameter gain 1.0", "a.formulas").parameters
        ),
    }
    app.extensions["seamark"].close()
    database.close()
    Path(folder, "shown.json").write_text(json.dumps(found), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])

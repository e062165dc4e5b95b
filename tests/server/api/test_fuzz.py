"""The interface keeps what its OpenAPI document promises, whatever is sent to it and by whom.

`./run fuzz-api [CASES]` sends as many random requests to each of the two databases; the test suite
sends a few.
"""

from collections.abc import Iterator
from itertools import count
from typing import Any

import pytest
from flask import Flask
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.web import rate_limits
from tests.cast import Backend
from tests.server.api.conftest import Site
from tests.server.judging.cup import NAME, Cup

ROLES = ("anonymous", "ann", "root")
ROUND = 20  # cases of an operation until the next one has its turn
PLAIN = {"Accept-Encoding": "identity"}  # schemathesis does not decompress what it gets by WSGI
ROWS = 6  # runs, and tokens that may be revoked
# These judge how strict a parser is; a lenient one (trials = "3") is meant here.
LENIENT = {"negative_data_rejection", "positive_data_acceptance", "ignored_auth"}


@pytest.fixture
def site(both: Backend, monkeypatch: pytest.MonkeyPatch) -> Iterator[Site]:
    """A service on each database with runs in several states, and without limits of numbers."""
    unlimited = {"quota_live": 10**6, "quota_day": 10**6, "ranked_day": 10**6}
    both.settings = both.settings.model_copy(update=unlimited)
    app = create_app(both.settings)
    monkeypatch.setattr(rate_limits.limiter, "enabled", False)
    headers: dict[str, dict[str, str]] = {"anonymous": PLAIN}
    with both.database.writing() as session:
        for name in ("ann", "root"):
            scopes = ("read", "submit", "admin")
            for _ in range(ROWS):
                accounts.new_token(session, both.user_id(name), "spare", scopes)
            token = accounts.new_token(session, both.user_id(name), "fuzz", scopes)
            headers[name] = PLAIN | {"Authorization": f"Bearer {token}"}
    site = Site(**vars(both), app=app, headers=headers)
    site.publish(site.recorded())
    site.publish(site.recorded(kind="ranked"))
    site.recorded()
    site.failed({"message": "it failed"})
    site.running("ann")  # without an event loop, the streams of live runs end with their start
    site.queue("ann")
    site.queue_check("ann")
    cup = Cup.opened(site)
    cup.team("ann", "ben")
    cup.entered("ann", [40.0, 41.0, 42.0])
    yield site
    site.services.close()


class Requests:
    """Draws requests to the interface of a document, for one test after the other.

    What draws them takes a second to make, and as long again to get ready as it draws the first.
    """

    own = 0  # the account of who asks

    def __init__(self, app: Flask) -> None:
        import schemathesis  # takes a tenth of what each process of tests takes to start

        schema: Any = schemathesis.openapi.from_wsgi("/api/v1/openapi.json", app)
        schema.hook("map_path_parameters")(
            lambda _context, values: _of_others(_with_ids_of_rows(values or {}), self.own)
        )
        schema.hook("map_body")(lambda _context, body: _of_a_benchmark(body))
        self.operations: list[Any] = [found.ok() for found in schema.get_all_operations()]


_REQUESTS: dict[str, Requests] = {}  # by the document


def _requests_to(app: Flask) -> Requests:
    document = app.test_client().get("/api/v1/openapi.json").text
    if document not in _REQUESTS:
        _REQUESTS[document] = Requests(app)
    return _REQUESTS[document]


def _with_ids_of_rows(parameters: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters with small ids replaced by those of rows, random names by real ones."""
    found = {
        name: _id_of_a_row(value) if isinstance(value, int) and value > 0 else value
        for name, value in parameters.items()
    }
    if len(str(found.get("benchmark", ""))) % 2:
        found["benchmark"] = "currents-v1"
    if len(str(found.get("name", ""))) % 2:
        found["name"] = NAME  # of a competition
    return found


def _of_others(parameters: dict[str, Any], own: int) -> dict[str, Any]:
    """Return the parameters without the own account: who revokes its token sees no more."""
    return parameters | ({"user_id": 1} if parameters.get("user_id") == own else {})


def _id_of_a_row(number: int) -> int:
    """Return an id, every other time that of the first run, which everybody may read."""
    left = number % (2 * ROWS)
    return left + 1 if left < ROWS else 1


def _of_a_benchmark(body: Any) -> Any:
    """Return the body with a benchmark and a program that exist, for every other one."""
    if isinstance(body, dict) and isinstance(body.get("run"), dict):
        return body | {"run": _of_a_benchmark(body["run"])}
    if isinstance(body, dict) and "benchmark" in body and len(str(body["benchmark"])) % 2:
        return body | {"benchmark": "currents-v1", "controller": "pi", "config": {}}
    return body


@pytest.mark.slow
@pytest.mark.parametrize("role", ROLES)
def test_every_response_matches_the_openapi_document(
    site: Site, role: str, request: pytest.FixtureRequest
) -> None:
    from schemathesis import Case
    from schemathesis.checks import CHECKS, not_a_server_error

    cases = -(-request.config.getoption("--api-cases") // len(ROLES))
    requests = _requests_to(site.app)
    requests.own = site.user_id(role) if role in site.viewers else 0
    drawn_for = f"{site.database.engine.dialect.name} {role}"  # else all draw the same requests
    checks: list[Any] = [check for check in CHECKS.get_all() if check.__name__ not in LENIENT]
    operations = requests.operations
    tried, answers = 0, set[tuple[str, int]]()
    assert not_a_server_error in checks

    for turn in count():
        for operation in operations:

            @seed(f"{drawn_for} {turn} {operation.label}")
            @settings(
                max_examples=min(ROUND, -(-cases // len(operations))),
                deadline=None,
                database=None,
                phases=(Phase.explicit, Phase.generate, Phase.shrink),
                suppress_health_check=list(HealthCheck),
            )
            @given(case=_cases(operation))
            def holds(case: Case[Any]) -> None:
                nonlocal tried
                tried += 1
                headers = site.headers[role]
                answer = case.call_and_validate(app=site.app, headers=headers, checks=checks)
                answers.add((f"{case.method} {case.path}", answer.status_code))

            holds()
        if tried >= cases:
            break

    served = {operation for operation, status in answers if status < 400}
    # Not all requests are refused. An anonymous one is by classes, teams and the administration;
    # what is drawn for the others, and so how many are served, depends on constants of our sources.
    assert len(served) > len(operations) / 8


def _cases(operation: Any) -> st.SearchStrategy[Any]:
    """Return valid and invalid requests of an operation."""
    from schemathesis import GenerationMode

    valid = operation.as_strategy(generation_mode=GenerationMode.POSITIVE)
    return st.one_of(valid, operation.as_strategy(generation_mode=GenerationMode.NEGATIVE))

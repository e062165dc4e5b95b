"""Who may call what: every route of the interface has a row here, or the test fails."""

from collections.abc import Callable
from typing import Any

import pytest

from tests.server.api.conftest import Site

ROLES = ("guest", "other", "owner", "admin", "reader", "submitter")
PRIVATE = (404, 404, 200, 200, 200, 403)
CHANGE = (404, 404, 200, 200, 403, 200)
ANYBODY = (200,) * 6
JSON: dict[str, Any] = {"json": {}}
ORDER: dict[str, Any] = {"json": {"benchmark": "currents-v1", "controller": "pi"}}

# route -> what kind of run it is tried on, the request's body, the status for each of ROLES
TABLE: dict[tuple[str, str], tuple[str, dict[str, Any], tuple[int, ...]]] = {
    ("GET", "/api/v1/benchmarks"): ("", {}, ANYBODY),
    ("GET", "/api/v1/benchmarks/<string:benchmark>"): ("", {}, ANYBODY),
    ("GET", "/api/v1/leaderboards/<string:benchmark>"): ("", {}, ANYBODY),
    ("GET", "/api/v1/openapi.json"): ("", {}, ANYBODY),
    ("GET", "/api/docs"): ("", {}, ANYBODY),
    ("GET", "/api/v1/me"): ("", {}, ANYBODY),
    ("GET", "/api/v1/runs"): ("", {}, (200, 200, 200, 200, 200, 403)),
    ("POST", "/api/v1/runs"): ("", ORDER, (202, 202, 202, 202, 403, 202)),
    ("POST", "/api/v1/checks"): ("", ORDER, (403, 422, 422, 422, 403, 422)),
    ("GET", "/api/v1/checks/<int:check_id>"): ("", {}, (401, 404, 200, 404, 200, 403)),
    ("GET", "/api/v1/runs/<int:run_id>"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/comparison"): (
        "private",
        {"query_string": {"with": 1}},
        (404, 404, 422, 422, 422, 403),
    ),
    ("POST", "/api/v1/runs/<int:run_id>/cancel"): ("queued", {}, CHANGE),
    ("POST", "/api/v1/runs/<int:run_id>/publish"): ("private", {}, CHANGE),
    ("POST", "/api/v1/runs/<int:run_id>/withdraw"): ("public", {}, (403, 403, 200, 200, 403, 200)),
    ("POST", "/api/v1/runs/<int:run_id>/rerun"): ("private", {}, (404, 404, 202, 403, 403, 202)),
    ("GET", "/api/v1/runs/<int:run_id>/events"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/telemetry.csv"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/telemetry.f64"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/series.json"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/metrics.json"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/manifest.json"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/config.json"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/log"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/program"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/camera.jpg"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/runs/<int:run_id>/dataset.zip"): ("private", {}, PRIVATE),
    ("GET", "/api/v1/tokens"): ("", {}, (401, 200, 200, 200, 200, 403)),
    ("POST", "/api/v1/tokens"): ("", JSON, (401, 201, 201, 201, 403, 403)),
    ("DELETE", "/api/v1/tokens/<int:token_id>"): ("", {}, (401, 404, 204, 404, 403, 204)),
}


def routes_of(site: Site) -> set[tuple[str, str]]:
    return {
        (method, rule.rule)
        for rule in site.app.url_map.iter_rules()
        if rule.rule.startswith("/api/")
        for method in (rule.methods or set()) - {"HEAD", "OPTIONS"}
    }


def run_of(site: Site, kind: str) -> int:
    makers: dict[str, Callable[[], int]] = {
        "": lambda: 1,
        "queued": site.queue,
        "private": site.recorded,
        "public": lambda: site.publish(site.recorded()),
    }
    return makers[kind]()


def spare_token(site: Site) -> int:
    """Return the number of a token of the owner that no role uses."""
    made = site.call("owner", "POST", "/api/v1/tokens", json={"name": "spare"})
    number: int = made.get_json()["id"]
    return number


def statuses(site: Site, role: str) -> dict[tuple[str, str], int]:
    found = {}
    for (method, rule), (kind, body, _) in TABLE.items():
        path = (
            rule.replace("<int:run_id>", str(run_of(site, kind)))
            .replace("<int:check_id>", str(site.queue_check() if "check_id" in rule else 0))
            .replace("<string:benchmark>", "currents-v1")
            .replace("<int:token_id>", str(spare_token(site) if "token_id" in rule else 0))
        )
        found[method, rule] = site.call(role, method, path, **body).status_code
        site.clear_queue()
    return found


def test_every_route_of_the_api_has_a_row_in_the_table(site: Site) -> None:
    assert routes_of(site) == set(TABLE)


@pytest.mark.parametrize("role", ROLES)
def test_each_role_gets_the_statuses_of_the_table(site: Site, role: str) -> None:
    expected = {route: row[2][ROLES.index(role)] for route, row in TABLE.items()}

    assert statuses(site, role) == expected


def test_an_expired_token_is_refused_everywhere(site: Site) -> None:
    assert set(statuses(site, "expired").values()) == {401}

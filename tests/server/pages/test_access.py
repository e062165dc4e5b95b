"""Every page for every role: what is private answers as if there were nothing."""

import re

import pytest

from tests.server.pages.conftest import Site

ROLES = ("stranger", "ben", "ann", "root")
OPEN = ("/", "/submit/currents-v1", "/runs/", "/leaderboards/currents-v1", "/sign-up", "/sign-in",
        "/status", "/docs/start", "/docs/controller", "/docs/runs", "/docs/metrics",
        "/docs/telemetry", "/docs/physics", "/docs/physics/girona500.urdf",
        "/benchmarks/currents-v1")  # fmt: skip
# request -> status for a stranger, ben, the owner, root
OF_PRIVATE_RUN = {
    ("GET", "/runs/{}"): (404, 404, 200, 200),
    ("POST", "/runs/{}/publish"): (404, 404, 303, 303),
    ("POST", "/runs/{}/withdraw"): (404, 404, 303, 303),
    ("POST", "/runs/{}/cancel"): (404, 404, 303, 303),
}
OF_PUBLIC_RUN = {
    ("GET", "/runs/{}"): (200, 200, 200, 200),
    ("POST", "/runs/{}/publish"): (403, 403, 303, 303),
    ("POST", "/runs/{}/withdraw"): (403, 403, 303, 303),
    ("POST", "/runs/{}/cancel"): (403, 403, 303, 303),
}


@pytest.mark.slow
@pytest.mark.parametrize("path", OPEN)
def test_public_pages_are_shown_to_everybody(site: Site, path: str) -> None:
    assert {site.browser(role).get(path).status_code for role in ROLES} == {200}


@pytest.mark.parametrize("asked", OF_PRIVATE_RUN, ids=" ".join)
def test_a_private_run_does_not_exist_for_others(site: Site, asked: tuple[str, str]) -> None:
    run_id = site.succeeded("ann")

    assert _answers(site, asked, run_id, "ann") == OF_PRIVATE_RUN[asked]


@pytest.mark.parametrize("asked", OF_PUBLIC_RUN, ids=" ".join)
def test_a_public_run_is_visible_to_all_but_changed_only_by_its_owner(
    site: Site, asked: tuple[str, str]
) -> None:
    run_id = site.published("eva")

    assert _answers(site, asked, run_id, "eva") == OF_PUBLIC_RUN[asked]


def _answers(site: Site, asked: tuple[str, str], run_id: int, owner: str) -> tuple[int, ...]:
    method, path = asked
    send = {"GET": "get", "POST": "post"}[method]
    address = path.format(run_id)
    return tuple(
        getattr(site.browser(role), send)(address).status_code
        for role in ("stranger", "ben", owner, "root")
    )


def test_a_private_run_answers_like_one_that_does_not_exist(site: Site) -> None:
    run_id = site.succeeded("ann")

    pages = [site.browser("ben").get(f"/runs/{i}").text for i in (run_id, run_id + 999)]
    private, none = (re.sub(r'name="csrf_token" value="[^"]+"', "", page) for page in pages)

    assert private == none


@pytest.mark.slow
@pytest.mark.parametrize("action", ["cancel", "publish", "withdraw"])
def test_nothing_is_changed_by_get(site: Site, action: str) -> None:
    run_id = site.succeeded("ann")
    before = site.show(run_id)

    answer = site.browser("ann").get(f"/runs/{run_id}/{action}")

    assert answer.status_code == (200 if action == "publish" else 405)  # a form
    assert site.show(run_id) == before
    assert not site.show(run_id).public


@pytest.mark.parametrize(
    "path", ["/tokens", "/tokens/1/revoke", "/sign-out", "/submit/currents-v1"]
)
def test_a_post_without_the_csrf_token_is_refused(site: Site, path: str) -> None:
    answer = site.browser("ann").client.post(path, data={"name": "x", "scopes": "read"})

    assert answer.status_code == 403
    assert "has expired" in answer.text


@pytest.mark.parametrize("name", ["cancel", "publish", "withdraw"])
def test_a_run_is_not_changed_without_the_csrf_token(site: Site, name: str) -> None:
    run_id = site.succeeded("ann")

    answer = site.browser("ann").client.post(f"/runs/{run_id}/{name}")

    assert (answer.status_code, site.show(run_id).public) == (403, False)


def test_the_api_refuses_a_cookie_without_the_csrf_token(site: Site) -> None:
    run_id = site.succeeded("ann")

    answer = site.browser("ann").client.post(f"/api/v1/runs/{run_id}/publish")

    assert (answer.status_code, site.show(run_id).public) == (403, False)


def test_only_an_admin_sees_private_runs_of_others_in_the_list(site: Site) -> None:
    run_id = site.succeeded("ann", title="secret plan")

    seen = {role: "secret plan" in site.browser(role).get("/runs/?of=all").text for role in ROLES}

    assert run_id
    assert seen == {"stranger": False, "ben": False, "ann": True, "root": True}

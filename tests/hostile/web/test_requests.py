"""Requests that a page of somebody else, a proxy or a forger makes: each is refused."""

import re
from itertools import product
from typing import Any

import pytest
from sqlalchemy import select

from seamark.server.accounts import accounts
from seamark.server.database.tables import Run, Token, User
from tests.server.pages.conftest import Site

UNSAFE = {"POST", "PUT", "PATCH", "DELETE"}
WORDS = "correct horse battery"
EVIL = "evil.example"
FORM = {"controller": "pi", "kind": "practice"}
RUN = {"benchmark": "currents-v1", "controller": "pi"}


def _filled_in(rule: Any) -> str:
    """Return an address of a route: 1 for numbers, a benchmark for names."""
    values = {
        name: 1 if "Id" in type(converter).__name__ or "Int" in type(converter).__name__ else "x"
        for name, converter in rule._converters.items()
    }
    built = rule.build(values)
    assert built is not None
    return str(built[1])


# -- cross-site request forgery ------------------------------------------------------------------


@pytest.mark.slow
def test_no_unsafe_route_accepts_a_cookie_without_the_csrf_token(site: Site) -> None:
    accepted, tried = [], 0
    for rule in site.app.url_map.iter_rules():
        for method in (rule.methods or set()) & UNSAFE:
            tried += 1
            bodies: tuple[dict[str, Any], ...] = (
                {"data": FORM},
                {"json": RUN},
                {"data": {"csrf_token": "guessed"}},
            )
            for options in bodies:
                client = site.browser("root").client
                answer = client.open(_filled_in(rule), method=method, **options)
                if answer.status_code != 403 or answer.headers.get("Location"):
                    accepted.append((method, rule.rule, answer.status_code))

    assert accepted == []
    assert tried > 15


def test_the_csrf_token_of_another_browser_is_refused(site: Site) -> None:
    foreign = site.browser("ben").csrf_token()

    answer = site.browser("ann").client.post("/tokens", data={"csrf_token": foreign})

    assert answer.status_code == 403


# -- mass assignment -----------------------------------------------------------------------------

EXTRA: dict[str, Any] = {
    "id": 77,
    "user_id": 1,
    "owner": "user:1",
    "public": True,
    "state": "succeeded",
    "score": 99.0,
    "attempt": 5,
    "queued_at": 0.0,
    "is_baseline": True,
    "role": "admin",
    "account_role": "admin",
    "scopes": "admin",
}


def test_the_api_refuses_what_a_run_does_not_let_its_sender_set(site: Site) -> None:
    browser = site.browser("ben")
    headers = {"X-CSRFToken": browser.csrf_token()}

    for member, value in EXTRA.items():
        answer = browser.client.post("/api/v1/runs", json=RUN | {member: value}, headers=headers)
        assert answer.status_code == 422
        assert answer.get_json()["errors"][0]["field"] == member


def test_further_fields_of_a_form_change_nothing(site: Site) -> None:
    browser, extra = site.browser("ben"), {key: str(value) for key, value in EXTRA.items()}

    assert browser.post("/submit/currents-v1", FORM | extra).status_code == 303

    with site.database.reading() as session:
        run = session.scalars(select(Run).order_by(Run.id.desc()).limit(1)).one()
    assert (run.user_id, run.owner) == (site.user_id("ben"), f"user:{site.user_id('ben')}")
    assert (run.state, run.public, run.attempt, run.id) == ("queued", False, 0, run.id)
    assert run.queued_at > 1e9


def test_signing_up_makes_a_user_whatever_else_is_sent(site: Site) -> None:
    extra = {key: str(value) for key, value in EXTRA.items()}

    site.browser().post("/sign-up", extra | {"name": "cleo", "password": WORDS})

    with site.database.reading() as session:
        made = session.scalars(select(User).where(User.name == "cleo")).one()
    assert (made.role, made.is_baseline, made.id != 77) == ("user", False, True)


@pytest.mark.slow
def test_a_token_and_a_password_belong_to_who_sends_the_form(site: Site) -> None:
    browser = site.browser()
    browser.post("/sign-up", {"name": "cleo", "password": "another long password"})
    root = str(site.user_id("root"))

    browser.post("/tokens", {"name": "t", "scopes": "read", "user_id": root, "viewer": "root"})
    forged = {"old": "anything else", "new": WORDS, "name": "root", "username": "root"}
    answer = browser.post("/password", forged)

    with site.database.reading() as session:
        owners = session.scalars(select(Token.user_id)).all()
        assert accounts.authenticate(session, "root", WORDS) is None
        assert owners == [accounts.person(session, "cleo").id]
    assert answer.status_code == 422


# -- redirects -----------------------------------------------------------------------------------

TARGETS = (
    f"https://{EVIL}/",
    f"http:{EVIL}",
    f"//{EVIL}",
    f"///{EVIL}",
    f"/\\{EVIL}",
    f"\\\\{EVIL}",
    f"/\t/{EVIL}",
    f"\t//{EVIL}",
    f" //{EVIL}",
    f"/\u200b/{EVIL}",
    f"https://localhost@{EVIL}/",
    f"//localhost:80@{EVIL}",
    "javascript:alert(1)",
    "data:text/html,x",
    f"{EVIL}",
)


@pytest.mark.slow
def test_nobody_is_sent_to_another_site_after_signing_in(site: Site) -> None:
    site.browser().post("/sign-up", {"name": "cleo", "password": WORDS})
    for target in TARGETS:
        form = {"name": "cleo", "password": WORDS, "next": target}
        answer = site.browser().post("/sign-in", form)
        assert (answer.status_code, answer.headers["Location"]) == (302, "/"), target


@pytest.mark.parametrize(
    "path", [f"//{EVIL}", f"//{EVIL}/..", f"//{EVIL}//runs", "//runs", f"/\\{EVIL}/", "///tokens"]
)
def test_no_address_is_redirected_to_another_site(site: Site, path: str) -> None:
    answer = site.browser().get("/", environ_overrides={"PATH_INFO": path})
    location = answer.headers.get("Location", "/")

    assert location.startswith("/")
    assert not location.startswith(("//", "/\\"))


# -- headers that a client or a proxy may forge --------------------------------------------------

FORGED = {
    "Host": EVIL,
    "X-Forwarded-Host": EVIL,
    "X-Forwarded-Server": EVIL,
    "X-Forwarded-Prefix": f"/{EVIL}",
    "X-Forwarded-Proto": "https",
    "X-Forwarded-Port": "31337",
    "Forwarded": f"host={EVIL};proto=https",
    "X-Original-URL": "/tokens",
    "X-Rewrite-URL": "/tokens",
    "X-HTTP-Method-Override": "DELETE",
}
PATHS = ("/", "/runs", "/runs/", "/submit", "/sign-in", "/leaderboards", "/tokens", "/docs/start")


@pytest.mark.slow
def test_a_forged_header_changes_neither_page_nor_redirect(site: Site) -> None:
    browser = site.browser()
    for path, name in product(PATHS, FORGED):
        plain = browser.get(path)
        forged = browser.get(path, headers={name: FORGED[name]})

        assert forged.status_code == plain.status_code
        assert forged.headers.get("Location") == plain.headers.get("Location")
        assert EVIL not in str(forged.headers)
        # As text it may be there: commands to copy name the address of the service.
        assert not re.search(rf'(href|src|action)="[^"]*{EVIL}', forged.text)


@pytest.mark.slow
def test_a_client_cannot_forge_the_address_that_rate_limits_count(site: Site) -> None:
    statuses = [
        site.browser()
        .post(
            "/sign-in",
            {"name": f"nobody{number}", "password": WORDS},
            headers={"X-Forwarded-For": f"192.0.2.{number}", "X-Real-IP": f"192.0.2.{number}"},
        )
        .status_code
        for number in range(11)
    ]

    assert statuses == [422] * 10 + [429]


# -- session fixation ----------------------------------------------------------------------------


@pytest.mark.slow
def test_a_planted_session_is_worth_nothing_after_its_victim_signs_in(site: Site) -> None:
    site.browser().post("/sign-up", {"name": "cleo", "password": WORDS})
    attacker, victim = site.browser(), site.browser()
    attacker.post("/submit/currents-v1", FORM)  # gives the attacker a session
    cookie = attacker.client.get_cookie("seamark")
    assert cookie is not None
    victim.client.set_cookie("seamark", cookie.value)
    known = attacker.csrf_token()

    assert victim.post("/sign-in", {"name": "cleo", "password": WORDS}).status_code == 302

    assert ">cleo<" in victim.get("/").text
    assert ">cleo<" not in attacker.get("/").text
    assert victim.client.post("/tokens", data={"csrf_token": known}).status_code == 403

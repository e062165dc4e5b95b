"""Signing in by an identity provider, against a real one, and attacks on it."""

import os
import re
import time
from collections.abc import Iterator
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest
from sqlalchemy import select
from werkzeug.test import TestResponse

from seamark.server.accounts import accounts, identities, invitations
from seamark.server.accounts.identities import Identity
from seamark.server.app import create_app
from seamark.server.audit import AuditAction
from seamark.server.database.audit_table import AuditEntry
from seamark.server.database.tables import BrowserSession
from seamark.server.runs import account_deletion
from seamark.server.web import authentication, identity_provider
from tests.cast import Backend
from tests.server.pages.conftest import Browser, Site
from tests.services import oidc
from tests.services.oidc import Person, Provider, path_of

URL = "http://localhost"
WORDS = "correct horse battery"

# The library allows plain HTTP, as of the provider here, only if it is told so.
os.environ.setdefault("AUTHLIB_INSECURE_TRANSPORT", "1")


@pytest.fixture
def provider() -> Iterator[Provider]:
    with oidc.provider(URL + identity_provider.CALLBACK) as started:
        yield started


@pytest.fixture
def backend(copied_backend: Backend) -> Backend:
    return copied_backend


@pytest.fixture
def site(backend: Backend, provider: Provider) -> Iterator[Site]:
    """The site with an identity provider; ann has a password."""
    with backend.database.writing() as session:
        accounts.change_password(session, "ann", WORDS)
    made = with_settings(backend, provider)
    yield made
    made.app.extensions["seamark"].close()


def with_settings(backend: Backend, provider: Provider, **changes: Any) -> Site:
    values = {"oidc_issuer": provider.issuer, "oidc_client_id": oidc.CLIENT, "url": URL}
    values |= {"oidc_client_secret": oidc.SECRET, "oidc_name": "Example ID"} | changes
    settings = backend.settings.model_copy(update=values)
    app = create_app(settings)
    cookies: dict[str, dict[str, Any]] = {"stranger": {}}
    with app.app_context():
        for name in ("ann", "ben"):
            cookies[name] = authentication.cookie_of(backend.user_id(name))
    state = vars(backend) | {"settings": settings}
    return Site(**state, app=app, cookies=cookies)


def come_back(browser: Browser, following: str = "/runs/") -> str:
    """Go to the provider, which agrees, and return the address to which it sends the browser."""
    there = browser.get(f"/sign-in/provider?next={following}").headers["Location"]
    return path_of(httpx.get(there).headers["Location"])


def sign_in(browser: Browser, following: str = "/runs/") -> TestResponse:
    return browser.get(come_back(browser, following))


def create(site: Site, name: str = "cleo") -> Browser:
    """Create an account by the identity of whoever is at the provider."""
    browser = site.browser()
    sign_in(browser)
    assert browser.post("/sign-up/provider", {"name": name}).status_code == 303
    return browser


def is_in(browser: Browser, name: str) -> bool:
    return f">{name}<" in browser.get("/").text


def test_the_first_sign_in_creates_an_account_and_the_next_one_finds_it(
    site: Site, provider: Provider
) -> None:
    browser = site.browser()

    first = sign_in(browser)
    form = browser.get(first.headers["Location"]).text
    refused = browser.post("/sign-up/provider", {"name": "ann"})
    created = browser.post("/sign-up/provider", {"name": "cleo"})
    provider.person.name = "another"
    again = site.browser()
    second = sign_in(again, "/docs/")

    assert (first.headers["Location"], refused.status_code) == ("/sign-up/provider", 422)
    assert 'value="Ann.Smith"' in form
    assert (created.status_code, created.headers["Location"]) == (303, "/runs/")
    assert (second.status_code, second.headers["Location"]) == (302, "/docs/")
    assert (is_in(browser, "cleo"), is_in(again, "cleo")) == (True, True)
    with site.database.reading() as session:
        assert accounts.person(session, "cleo").password_hash is None


def test_the_browser_is_sent_with_state_nonce_and_a_challenge(
    site: Site, provider: Provider
) -> None:
    answer = site.browser().get("/sign-in/provider")

    there = urlsplit(answer.headers["Location"])
    sent = {name: values[0] for name, values in parse_qs(there.query).items()}
    assert f"{there.scheme}://{there.netloc}" == provider.issuer
    assert sent["code_challenge_method"] == "S256"
    assert all(len(sent[name]) >= 20 for name in ("state", "nonce", "code_challenge"))
    assert (sent["response_type"], sent["scope"]) == ("code", "openid profile")
    assert sent["redirect_uri"] == URL + identity_provider.CALLBACK
    assert oidc.SECRET not in there.query


def test_an_account_is_found_by_the_subject_and_never_by_the_name(
    site: Site, provider: Provider
) -> None:
    create(site)
    provider.person = Person("somebody else", "cleo")

    browser = site.browser()
    answer = sign_in(browser)

    assert answer.headers["Location"] == "/sign-up/provider"
    assert not is_in(browser, "cleo")


def _other(**claims: Any) -> Any:
    return lambda known: known | claims


def _without(name: str) -> Any:
    return lambda known: {key: value for key, value in known.items() if key != name}


WRONG_TOKENS = {
    "another nonce": _other(nonce="another"),
    "no nonce": _without("nonce"),
    "for another": _other(aud="another service"),
    "for two others": _other(aud=["another service", "yet another"]),
    "for nobody": _without("aud"),
    "of another": _other(iss="http://127.0.0.1:1"),
    "expired": _other(exp=int(time.time()) - 1000),
    "for ever": _without("exp"),
    "no subject": _without("sub"),
    "an empty subject": _other(sub=""),
    "a long subject": _other(sub="x" * 256),
    "given to another": _other(azp="another service"),
}


def test_a_token_that_is_not_for_this_sign_in_signs_nobody_in(
    site: Site, provider: Provider
) -> None:
    create(site)

    outcomes = {}
    for attack, change in WRONG_TOKENS.items():
        provider.change, browser = change, site.browser()
        answer = sign_in(browser)
        said = "did not confirm this sign-in" in answer.text
        outcomes[attack] = (answer.status_code, said, is_in(browser, "cleo"))

    assert outcomes == dict.fromkeys(WRONG_TOKENS, (403, True, False))


@pytest.mark.parametrize("attack", ["another key", "HS256", "none"])
def test_a_token_that_the_provider_has_not_signed_signs_nobody_in(
    backend: Backend, site: Site, provider: Provider, attack: str
) -> None:
    create(site)
    if attack == "another key":
        true = provider.key
        provider.key = oidc.new_key("another")
        provider.change_metadata = lambda known: known | {"jwks": {"keys": [true.as_dict()]}}
        site = with_settings(backend, provider)
    else:
        provider.signs = attack

    browser = site.browser()
    answer = sign_in(browser)

    assert (answer.status_code, is_in(browser, "cleo")) == (403, False)


def test_what_comes_back_to_another_browser_signs_nobody_in(site: Site) -> None:
    create(site)
    own, victim = site.browser(), site.browser()
    address = come_back(own)

    answers = [
        victim.get(address),  # started elsewhere
        own.get(re.sub("state=[^&]+", "state=another", address)),
        own.get(re.sub("&?state=[^&]+", "", address)),
    ]

    assert [answer.status_code for answer in answers] == [403, 403, 403]
    assert (is_in(own, "cleo"), is_in(victim, "cleo")) == (False, False)


def test_a_code_works_once(site: Site) -> None:
    create(site)
    browser = site.browser()
    address = come_back(browser)
    with browser.client.session_transaction() as cookie:
        before = dict(cookie)

    first = browser.get(address)
    with browser.client.session_transaction() as cookie:
        cookie.clear()
        cookie.update(before)
    again = browser.get(address)

    assert (first.status_code, again.status_code) == (302, 403)


def test_a_code_is_worth_nothing_without_the_verifier_of_its_browser(site: Site) -> None:
    create(site)
    thief = site.browser()
    stolen = parse_qs(urlsplit(come_back(site.browser())).query)["code"][0]
    own = come_back(thief)

    answer = thief.get(re.sub("code=[^&]+", f"code={stolen}", own))

    assert (answer.status_code, is_in(thief, "cleo")) == (403, False)


def test_a_refusal_at_the_provider_is_said_on_a_page(site: Site) -> None:
    browser = site.browser()
    address = come_back(browser)

    answer = browser.get(f"{address}&error=access_denied&error_description=<script>")

    assert (answer.status_code, "Not signed in" in answer.text) == (403, True)
    assert "<script>alert" not in answer.text
    assert "access_denied" not in answer.text


def test_signing_in_never_leads_to_another_site(site: Site) -> None:
    create(site)
    evil = ["https://evil.example/", "//evil.example", "/\\evil.example", "\\\\evil.example"]

    assert {sign_in(site.browser(), each).headers["Location"] for each in evil} == {"/"}


def test_a_provider_that_is_away_is_said_on_a_page(backend: Backend, provider: Provider) -> None:
    site = with_settings(backend, provider, oidc_issuer="http://127.0.0.1:1")

    answer = site.browser().get("/sign-in/provider")

    assert (answer.status_code, "does not answer at the moment" in answer.text) == (503, True)
    site.app.extensions["seamark"].close()


def test_a_provider_that_is_silent_is_not_waited_for(
    backend: Backend, provider: Provider, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identity_provider, "TIMEOUT_S", 0.2)
    site = with_settings(backend, provider)
    provider.pause_s = 1.0

    answer = site.browser().get("/sign-in/provider")

    assert answer.status_code == 503
    site.app.extensions["seamark"].close()


@pytest.mark.parametrize(
    "change", [_other(issuer="http://127.0.0.1:2"), _without("token_endpoint")]
)
def test_metadata_of_another_provider_sends_nobody_away(
    backend: Backend, provider: Provider, change: Any
) -> None:
    provider.change_metadata = change
    site = with_settings(backend, provider)

    browser = site.browser()
    answer = browser.get("/sign-in/provider")
    if answer.status_code == 302:
        answer = browser.get(path_of(httpx.get(answer.headers["Location"]).headers["Location"]))

    assert answer.status_code in {403, 503}
    site.app.extensions["seamark"].close()


def test_a_disabled_account_is_not_signed_in(site: Site) -> None:
    create(site)
    with site.database.writing() as session:
        accounts.person(session, "cleo").disabled_at = time.time()

    browser = site.browser()
    answer = sign_in(browser)

    assert (answer.status_code, "This account is disabled" in answer.text) == (403, True)
    assert not is_in(browser, "cleo")


def test_signing_up_by_the_provider_has_a_setting_of_its_own(
    backend: Backend, provider: Provider
) -> None:
    statuses = {}
    for mode in ("closed", "invitation", "open"):
        site = with_settings(backend, provider, sign_up="closed", oidc_sign_up=mode)
        provider.person = Person(mode)
        browser = site.browser()
        sign_in(browser)
        statuses[mode] = browser.post("/sign-up/provider", {"name": f"by-{mode}"}).status_code
        if mode == "invitation":
            with site.database.writing() as session:
                (text,) = invitations.create(session, days=1.0)
            form = {"name": f"by-{mode}", "invitation": text}
            statuses["invited"] = browser.post("/sign-up/provider", form).status_code
        site.app.extensions["seamark"].close()

    assert statuses == {"closed": 403, "invitation": 422, "invited": 303, "open": 303}


def test_an_account_is_linked_after_a_question_and_with_the_password(
    site: Site, provider: Provider
) -> None:
    browser = site.browser("ann")
    asked = sign_in(browser, "/account")
    question = browser.get("/account/identity").text
    before = sign_in(site.browser()).headers["Location"]

    wrong = browser.post("/account/identity", {"password": "wrong"})
    linked = browser.post("/account/identity", {"password": WORDS})
    page = browser.get("/account").text
    other = site.browser()
    sign_in(other)
    unlinked = browser.post("/account/identity/unlink")

    assert asked.headers["Location"] == "/account/identity"
    assert "<bdi>Ann.Smith</bdi>" in question
    assert before == "/sign-up/provider"
    assert (wrong.status_code, linked.status_code, unlinked.status_code) == (422, 303, 303)
    assert "as <bdi>Ann.Smith</bdi>" in page
    assert is_in(other, "ann")
    assert sign_in(site.browser()).headers["Location"] == "/sign-up/provider"
    with site.database.reading() as session:
        done = [tuple(row) for row in session.execute(select(AuditEntry.action, AuditEntry.actor))]
    wanted = [(AuditAction.IDENTITY_LINKED, "ann"), (AuditAction.IDENTITY_UNLINKED, "ann")]
    assert done == wanted


def test_an_identity_has_one_account_and_an_account_one_identity(
    site: Site, provider: Provider
) -> None:
    create(site)
    browser = site.browser("ann")

    sign_in(browser)
    taken = browser.post("/account/identity", {"password": WORDS})
    provider.person = Person("second")
    sign_in(browser)
    browser.post("/account/identity", {"password": WORDS})
    provider.person = Person("third")
    sign_in(browser)
    third = browser.post("/account/identity", {"password": WORDS})

    assert "linked to another account" in taken.text
    assert "Another identity is linked" in third.text


def test_the_only_way_into_an_account_is_not_unlinked(site: Site) -> None:
    browser = create(site)

    refused = browser.post("/account/identity/unlink")
    with_one = browser.post("/password", {"new": WORDS})
    unlinked = browser.post("/account/identity/unlink")

    assert (refused.status_code, "Set a password first" in refused.text) == (422, True)
    assert (with_one.status_code, unlinked.status_code) == (302, 303)


@pytest.mark.parametrize(
    ("path", "form"),
    [
        ("/password", {"new": WORDS}),
        ("/account/delete", {"confirm": "cleo"}),
    ],
)
def test_an_account_without_a_password_is_changed_soon_after_signing_in_only(
    site: Site, path: str, form: dict[str, str]
) -> None:
    browser = create(site)
    with site.database.writing() as session:
        for row in session.scalars(select(BrowserSession)):
            row.created_at -= 601.0
    late = browser.post(path, form)
    browser.post("/sign-out")
    sign_in(browser)
    soon = browser.post(path, form)

    assert (late.status_code, "within ten minutes" in late.text) == (422, True)
    assert soon.status_code in {302, 303}


def test_a_kept_identity_is_worth_nothing_after_a_while(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = site.browser()
    sign_in(browser)
    monkeypatch.setattr(identity_provider, "PENDING_S", 0.0)
    time.sleep(0.01)

    answer = browser.post("/sign-up/provider", {"name": "cleo"})

    assert answer.headers["Location"] == "/sign-in"
    with site.database.reading() as session, pytest.raises(accounts.AccountRejected):
        accounts.person(session, "cleo")


def test_many_started_sign_ins_do_not_fill_the_cookie(site: Site) -> None:
    browser = site.browser()

    for _ in range(8):
        browser.get("/sign-in/provider")

    cookie = browser.client.get_cookie("seamark")
    assert cookie is not None
    assert len(cookie.value) < 1000


def test_the_data_of_an_account_name_its_identity_and_closing_it_forgets_it(site: Site) -> None:
    with site.database.writing() as session:
        ann = site.user_id("ann")
        identities.link(session, ann, Identity(issuer="https://i.example", subject="s"))
        account_deletion.close(session, ann, keep_published=True)

        assert identities.all_of(session, ann) == []


@pytest.mark.parametrize("path", ["/sign-in/provider", "/sign-up/provider", "/account/identity"])
def test_without_a_provider_there_is_no_page_about_one(backend: Backend, path: str) -> None:
    client = create_app(backend.settings).test_client()

    assert client.get(path).status_code == 404
    assert "provider" not in client.get("/sign-in").text

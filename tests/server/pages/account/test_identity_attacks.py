"""Attacks on signing in by an identity provider, and a provider that fails."""

import re
import time
from typing import Any
from urllib.parse import parse_qs, urlsplit

import httpx
import pytest

from seamark.client.sessions import NO_CERTIFICATES
from seamark.server.web import identity_provider
from tests.cast import Backend
from tests.server.pages.account.sign_ins import come_back, create, is_in, sign_in
from tests.server.pages.conftest import Site, with_settings
from tests.services import oidc
from tests.services.oidc import Provider, path_of


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


@pytest.mark.slow
def test_a_token_that_is_not_for_this_sign_in_signs_nobody_in(
    federated: Site, provider: Provider
) -> None:
    create(federated)

    outcomes = {}
    for attack, change in WRONG_TOKENS.items():
        provider.change, browser = change, federated.browser()
        answer = sign_in(browser)
        said = "did not confirm this sign-in" in answer.text
        outcomes[attack] = (answer.status_code, said, is_in(browser, "cleo"))

    assert outcomes == dict.fromkeys(WRONG_TOKENS, (403, True, False))


@pytest.mark.slow
@pytest.mark.parametrize("attack", ["another key", "HS256", "none"])
def test_a_token_that_the_provider_has_not_signed_signs_nobody_in(
    backend: Backend, federated: Site, provider: Provider, attack: str
) -> None:
    create(federated)
    if attack == "another key":
        true = provider.key
        provider.key = oidc.new_key("another")
        provider.change_metadata = lambda known: known | {"jwks": {"keys": [true.as_dict()]}}
        federated = with_settings(backend, provider)
    else:
        provider.signs = attack

    browser = federated.browser()
    answer = sign_in(browser)

    assert (answer.status_code, is_in(browser, "cleo")) == (403, False)


@pytest.mark.slow
def test_what_comes_back_to_another_browser_signs_nobody_in(federated: Site) -> None:
    create(federated)
    own, victim = federated.browser(), federated.browser()
    address = come_back(own)

    answers = [
        victim.get(address),  # started elsewhere
        own.get(re.sub("state=[^&]+", "state=another", address)),
        own.get(re.sub("&?state=[^&]+", "", address)),
    ]

    assert [answer.status_code for answer in answers] == [403, 403, 403]
    assert (is_in(own, "cleo"), is_in(victim, "cleo")) == (False, False)


@pytest.mark.slow
def test_a_code_works_once(federated: Site) -> None:
    create(federated)
    browser = federated.browser()
    address = come_back(browser)
    with browser.client.session_transaction() as cookie:
        before = dict(cookie)

    first = browser.get(address)
    with browser.client.session_transaction() as cookie:
        cookie.clear()
        cookie.update(before)
    again = browser.get(address)

    assert (first.status_code, again.status_code) == (302, 403)


@pytest.mark.slow
def test_a_code_is_worth_nothing_without_the_verifier_of_its_browser(federated: Site) -> None:
    create(federated)
    thief = federated.browser()
    stolen = parse_qs(urlsplit(come_back(federated.browser())).query)["code"][0]
    own = come_back(thief)

    answer = thief.get(re.sub("code=[^&]+", f"code={stolen}", own))

    assert (answer.status_code, is_in(thief, "cleo")) == (403, False)


@pytest.mark.slow
def test_a_refusal_at_the_provider_is_said_on_a_page(federated: Site) -> None:
    browser = federated.browser()
    address = come_back(browser)

    answer = browser.get(f"{address}&error=access_denied&error_description=<script>")

    assert (answer.status_code, "Not signed in" in answer.text) == (403, True)
    assert "<script>alert" not in answer.text
    assert "access_denied" not in answer.text


@pytest.mark.slow
def test_signing_in_never_leads_to_another_site(federated: Site) -> None:
    create(federated)
    evil = ["https://evil.example/", "//evil.example", "/\\evil.example", "\\\\evil.example"]

    assert {sign_in(federated.browser(), each).headers["Location"] for each in evil} == {"/"}


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
        agreed = httpx.get(answer.headers["Location"], verify=NO_CERTIFICATES)
        answer = browser.get(path_of(agreed.headers["Location"]))

    assert answer.status_code in {403, 503}
    site.app.extensions["seamark"].close()


@pytest.mark.slow
def test_many_started_sign_ins_do_not_fill_the_cookie(federated: Site) -> None:
    browser = federated.browser()

    for _ in range(8):
        browser.get("/sign-in/provider")

    cookie = browser.client.get_cookie("seamark")
    assert cookie is not None
    assert len(cookie.value) < 1000

"""Signing in by an identity provider, against a real one: accounts, links."""

import time
from urllib.parse import parse_qs, urlsplit

import pytest
from sqlalchemy import select

from seamark.server.accounts import accounts, identities, invitations
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.identities import Identity
from seamark.server.app import create_app
from seamark.server.database.operation_tables import AuditEntry
from seamark.server.database.tables import BrowserSession
from seamark.server.runs.ending import account_deletion
from seamark.server.web import identity_provider
from tests.cast import Backend
from tests.server.pages.account.sign_ins import create, is_in, sign_in
from tests.server.pages.conftest import URL, WORDS, Site, with_settings
from tests.services import oidc
from tests.services.oidc import Person, Provider


@pytest.mark.slow
def test_the_first_sign_in_creates_an_account_and_the_next_one_finds_it(
    federated: Site, provider: Provider
) -> None:
    browser = federated.browser()

    first = sign_in(browser)
    form = browser.get(first.headers["Location"]).text
    refused = browser.post("/sign-up/provider", {"name": "ann"})
    created = browser.post("/sign-up/provider", {"name": "cleo"})
    provider.person.name = "another"
    again = federated.browser()
    second = sign_in(again, "/docs/")

    assert (first.headers["Location"], refused.status_code) == ("/sign-up/provider", 422)
    assert 'value="Ann.Smith"' in form
    assert (created.status_code, created.headers["Location"]) == (303, "/runs/")
    assert (second.status_code, second.headers["Location"]) == (302, "/docs/")
    assert (is_in(browser, "cleo"), is_in(again, "cleo")) == (True, True)
    with federated.database.reading() as session:
        assert accounts.person(session, "cleo").password_hash is None


@pytest.mark.slow
def test_the_browser_is_sent_with_state_nonce_and_a_challenge(
    federated: Site, provider: Provider
) -> None:
    answer = federated.browser().get("/sign-in/provider")

    there = urlsplit(answer.headers["Location"])
    sent = {name: values[0] for name, values in parse_qs(there.query).items()}
    assert f"{there.scheme}://{there.netloc}" == provider.issuer
    assert sent["code_challenge_method"] == "S256"
    assert all(len(sent[name]) >= 20 for name in ("state", "nonce", "code_challenge"))
    assert (sent["response_type"], sent["scope"]) == ("code", "openid profile")
    assert sent["redirect_uri"] == URL + identity_provider.CALLBACK
    assert oidc.SECRET not in there.query


@pytest.mark.slow
def test_an_account_is_found_by_the_subject_and_never_by_the_name(
    federated: Site, provider: Provider
) -> None:
    create(federated)
    provider.person = Person("somebody else", "cleo")

    browser = federated.browser()
    answer = sign_in(browser)

    assert answer.headers["Location"] == "/sign-up/provider"
    assert not is_in(browser, "cleo")


@pytest.mark.slow
def test_a_disabled_account_is_not_signed_in(federated: Site) -> None:
    create(federated)
    with federated.database.writing() as session:
        accounts.person(session, "cleo").disabled_at = time.time()

    browser = federated.browser()
    answer = sign_in(browser)

    assert (answer.status_code, "This account is disabled" in answer.text) == (403, True)
    assert not is_in(browser, "cleo")


@pytest.mark.slow
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


@pytest.mark.slow
def test_an_account_is_linked_after_a_question_and_with_the_password(
    federated: Site, provider: Provider
) -> None:
    browser = federated.browser("ann")
    asked = sign_in(browser, "/account")
    question = browser.get("/account/identity").text
    before = sign_in(federated.browser()).headers["Location"]

    wrong = browser.post("/account/identity", {"password": "wrong"})
    linked = browser.post("/account/identity", {"password": WORDS})
    page = browser.get("/account").text
    other = federated.browser()
    sign_in(other)
    unlinked = browser.post("/account/identity/unlink")

    assert asked.headers["Location"] == "/account/identity"
    assert "<bdi>Ann.Smith</bdi>" in question
    assert before == "/sign-up/provider"
    assert (wrong.status_code, linked.status_code, unlinked.status_code) == (422, 303, 303)
    assert "as <bdi>Ann.Smith</bdi>" in page
    assert is_in(other, "ann")
    assert sign_in(federated.browser()).headers["Location"] == "/sign-up/provider"
    with federated.database.reading() as session:
        done = [tuple(row) for row in session.execute(select(AuditEntry.action, AuditEntry.actor))]
    wanted = [(AuditAction.IDENTITY_LINKED, "ann"), (AuditAction.IDENTITY_UNLINKED, "ann")]
    assert done == wanted


@pytest.mark.slow
def test_an_identity_has_one_account_and_an_account_one_identity(
    federated: Site, provider: Provider
) -> None:
    create(federated)
    browser = federated.browser("ann")

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


@pytest.mark.slow
def test_the_only_way_into_an_account_is_not_unlinked(federated: Site) -> None:
    browser = create(federated)

    refused = browser.post("/account/identity/unlink")
    with_one = browser.post("/password", {"new": WORDS})
    unlinked = browser.post("/account/identity/unlink")

    assert (refused.status_code, "Set a password first" in refused.text) == (422, True)
    assert (with_one.status_code, unlinked.status_code) == (302, 303)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "form"),
    [
        ("/password", {"new": WORDS}),
        ("/account/delete", {"confirm": "cleo"}),
    ],
)
def test_an_account_without_a_password_is_changed_soon_after_signing_in_only(
    federated: Site, path: str, form: dict[str, str]
) -> None:
    browser = create(federated)
    with federated.database.writing() as session:
        for row in session.scalars(select(BrowserSession)):
            row.created_at -= 601.0
    late = browser.post(path, form)
    browser.post("/sign-out")
    sign_in(browser)
    soon = browser.post(path, form)

    assert (late.status_code, "within ten minutes" in late.text) == (422, True)
    assert soon.status_code in {302, 303}


@pytest.mark.slow
def test_a_kept_identity_is_worth_nothing_after_a_while(
    federated: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    browser = federated.browser()
    sign_in(browser)
    monkeypatch.setattr(identity_provider, "PENDING_S", 0.0)
    time.sleep(0.01)

    answer = browser.post("/sign-up/provider", {"name": "cleo"})

    assert answer.headers["Location"] == "/sign-in"
    with federated.database.reading() as session, pytest.raises(accounts.AccountRejected):
        accounts.person(session, "cleo")


def test_closing_an_account_forgets_its_identity(
    federated: Site,
) -> None:
    with federated.database.writing() as session:
        ann = federated.user_id("ann")
        identities.link(session, ann, Identity(issuer="https://i.example", subject="s"))
        account_deletion.close(session, ann, keep_published=True)

        assert identities.all_of(session, ann) == []


@pytest.mark.parametrize("path", ["/sign-in/provider", "/sign-up/provider", "/account/identity"])
def test_without_a_provider_there_is_no_page_about_one(backend: Backend, path: str) -> None:
    client = create_app(backend.settings).test_client()

    assert client.get(path).status_code == 404
    assert "provider" not in client.get("/sign-in").text

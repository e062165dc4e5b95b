"""E-mail on the pages: addresses, confirmation, notices, forgotten passwords."""

import json
import re
from dataclasses import replace
from io import BytesIO
from zipfile import ZipFile

import pytest
from sqlalchemy import select

from seamark.server.accounts import accounts, identities
from seamark.server.accounts.audit import AuditAction
from seamark.server.accounts.identities import Identity
from seamark.server.database.mail_tables import OutgoingMail
from seamark.server.database.operation_tables import AuditEntry
from seamark.server.mail import addresses
from seamark.server.mail.outbox import MailKind
from tests.server.pages.conftest import Site

WORDS = "correct horse battery"
ADDRESS = "ann@example.org"
FORM = {"address": ADDRESS, "password": WORDS}


@pytest.fixture
def mailing(site: Site) -> Site:
    """The site, which sends e-mail, and in which ann has a password."""
    current = site.app.extensions["seamark"]
    changes = {"mail_url": "smtp://127.0.0.1", "mail_from": "a@b.c", "url": "https://s.example"}
    settings = current.settings.model_copy(update=changes)
    site.app.extensions["seamark"] = replace(current, settings=settings)
    with site.database.writing() as session:
        accounts.change_password(session, "ann", WORDS)
    site.sign_in("ann")
    return site


def kinds(site: Site) -> list[str]:
    with site.database.reading() as session:
        return list(session.scalars(select(OutgoingMail.kind).order_by(OutgoingMail.id)))


def link_of(site: Site, name: str) -> str:
    with site.database.writing() as session:
        drawn = addresses.draw_link(session, site.user_id(name))
    assert drawn is not None
    return drawn[1]


def confirmed(site: Site) -> None:
    site.browser("ann").post("/account/mail", FORM)
    site.browser().post("/mail/confirm", {"link": link_of(site, "ann")})


@pytest.mark.slow
def test_an_address_is_entered_confirmed_and_removed_on_the_pages(mailing: Site) -> None:
    browser = mailing.browser("ann")

    entered = browser.post("/account/mail", FORM)
    pending = browser.get("/account").text
    link = link_of(mailing, "ann")
    shown = mailing.browser().get(f"/mail/confirm?link={link}")
    answer = mailing.browser().post("/mail/confirm", {"link": link})
    again = mailing.browser().post("/mail/confirm", {"link": link})
    after = browser.get("/account").text
    removed = browser.post("/account/mail/remove", follow_redirects=True).text

    assert (entered.status_code, kinds(mailing)) == (303, [MailKind.CONFIRMATION])
    assert f"A link has been sent to <bdi>{ADDRESS}</bdi>" in pending
    assert f'value="{link}"' in shown.text
    assert (answer.status_code, again.status_code) == (303, 422)
    assert f"<bdi>{ADDRESS}</bdi> " in after
    assert ADDRESS not in removed
    with mailing.database.reading() as session:
        actions = session.execute(select(AuditEntry.action, AuditEntry.target)).all()
        details = str(session.scalars(select(AuditEntry.detail)).all())
    wanted = [(AuditAction.MAIL_ADDRESS_CHANGED, "ann"), (AuditAction.MAIL_ADDRESS_REMOVED, "ann")]
    assert [tuple(row) for row in actions] == wanted
    assert ADDRESS not in details


@pytest.mark.slow
@pytest.mark.parametrize(
    ("form", "says"),
    [
        (FORM | {"password": "wrong"}, "The current password is incorrect."),
        (FORM | {"address": "a@b\r\nBcc: c@d"}, "Enter an e-mail address"),
    ],
)
def test_an_address_needs_the_password_and_a_form(
    mailing: Site, form: dict[str, str], says: str
) -> None:
    answer = mailing.browser("ann").post("/account/mail", form)

    assert (answer.status_code, says in answer.text, kinds(mailing)) == (422, True, [])


@pytest.mark.slow
def test_looking_at_a_link_confirms_nothing(mailing: Site) -> None:
    mailing.browser("ann").post("/account/mail", FORM)

    mailing.browser().get(f"/mail/confirm?link={link_of(mailing, 'ann')}")

    with mailing.database.reading() as session:
        assert addresses.of_account(session, mailing.user_id("ann")).address is None


@pytest.mark.slow
def test_the_answer_is_the_same_for_an_address_that_nobody_has(mailing: Site) -> None:
    confirmed(mailing)

    def answer(address: str) -> tuple[int, str]:
        got = mailing.browser().post("/forgot", {"address": address})
        text = re.sub(r'value="[^"]+"', "", got.text)
        return got.status_code, text.replace(address, "ADDRESS")

    known, unknown = answer(ADDRESS), answer("nobody@example.org")

    assert known == unknown
    assert kinds(mailing)[1:] == [MailKind.RESET, MailKind.RESET]


@pytest.mark.slow
def test_notices_are_chosen_on_the_page_and_by_the_api(mailing: Site) -> None:
    browser = mailing.browser("ann")
    early = browser.post("/account/mail/notify", {"minutes": "30"})
    confirmed(mailing)

    by_page = browser.post("/account/mail/notify", {"minutes": "30"})
    page = browser.get("/account").text
    token = {"X-CSRFToken": browser.csrf_token()}
    by_api = browser.client.patch("/api/v1/me/mail", json={"notify_minutes": 7}, headers=token)
    refused = browser.client.patch("/api/v1/me/mail", json={"notify_minutes": -1}, headers=token)
    browser.post("/account/mail/notify", {"minutes": ""})

    assert (early.status_code, by_page.status_code, refused.status_code) == (422, 303, 422)
    assert '<option value="30" selected>After 30 minutes or more</option>' in page
    assert by_api.json == {"address": ADDRESS, "pending": None, "notify_minutes": 7}
    final = browser.get("/api/v1/me/mail").json
    assert final is not None
    assert final["notify_minutes"] is None


@pytest.mark.slow
def test_the_data_of_an_account_have_its_address_and_its_identities(mailing: Site) -> None:
    confirmed(mailing)
    with mailing.database.writing() as session:
        identity = Identity(issuer="https://id.example", subject="7", label="Ann")
        identities.link(session, mailing.user_id("ann"), identity)

    archive = ZipFile(BytesIO(mailing.browser("ann").get("/account/data.zip").data))
    account = json.loads(archive.read("account.json"))

    assert account["mail"] == {"address": ADDRESS, "not_confirmed": None, "notify_minutes": None}
    linked = {"issuer": "https://id.example", "subject": "7", "name": "Ann"}
    assert account["identities"] == [linked]


@pytest.mark.slow
def test_nobody_else_sees_an_address(mailing: Site) -> None:
    confirmed(mailing)
    ann = mailing.user_id("ann")

    pages = [
        mailing.browser(who).get(path).text
        for who in ("ben", "root")
        for path in ("/users/ann", f"/admin/users/{ann}", f"/api/v1/admin/users/{ann}", "/account")
    ]

    assert all(ADDRESS not in text for text in pages)


@pytest.mark.parametrize("path", ["/forgot", "/mail/confirm", "/api/v1/me/mail"])
def test_without_a_mail_server_there_is_no_page_about_e_mail(site: Site, path: str) -> None:
    browser = site.browser("ann")

    assert browser.get(path).status_code == 404
    for shown in ("/account", "/sign-in"):
        assert not re.search(r"E-mail|/forgot", browser.get(shown).text)

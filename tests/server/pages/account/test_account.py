"""Signing up, in and out, and tokens."""

import re
from dataclasses import replace

import pytest
from sqlalchemy import select

from seamark.server.accounts import accounts, invitations
from seamark.server.database.tables import Token
from seamark.server.web import authentication
from tests.server.pages.conftest import Browser, Site

WORDS = "correct horse battery"


def test_signing_up_signs_in_and_out_again(site: Site) -> None:
    browser = site.browser()

    answer = browser.post("/sign-up", {"name": "cleo", "password": WORDS})
    inside = browser.get("/").text
    browser.post("/sign-out")
    outside = browser.get("/").text

    assert answer.status_code == 302
    assert (">cleo<" in inside, ">cleo<" in outside) == (True, False)


@pytest.mark.slow
def test_a_wrong_password_and_an_unknown_name_get_the_same_answer(site: Site) -> None:
    site.browser().post("/sign-up", {"name": "cleo", "password": WORDS})

    def refusal(name: str) -> tuple[int, str]:
        answer = site.browser().post("/sign-in", {"name": name, "password": "wrong wrong"})
        return answer.status_code, re.findall(r'role="alert"><p>([^<]+)', answer.text)[0]

    assert refusal("cleo") == refusal("nobody")


@pytest.mark.slow
def test_the_right_password_signs_in(site: Site) -> None:
    site.browser().post("/sign-up", {"name": "cleo", "password": WORDS})
    browser = site.browser()

    answer = browser.post("/sign-in", {"name": "Cleo", "password": WORDS, "next": "/runs/"})

    assert (answer.status_code, answer.headers["Location"]) == (302, "/runs/")


@pytest.mark.slow
@pytest.mark.parametrize(
    "wanted", ["https://evil.example/", "//evil.example", "/\\evil.example", "\\\\evil.example", ""]
)
def test_signing_up_never_redirects_to_another_site(site: Site, wanted: str) -> None:
    form = {"name": "cleo", "password": WORDS, "next": wanted}

    assert site.browser().post("/sign-up", form).headers["Location"] == "/"


@pytest.mark.parametrize(
    ("name", "password"), [("ann", WORDS), ("x", WORDS), ("<b>", WORDS), ("cleo", "short")]
)
def test_a_refused_account_says_why_and_keeps_the_name(
    site: Site, name: str, password: str
) -> None:
    answer = site.browser().post("/sign-up", {"name": name, "password": password})

    assert answer.status_code == 422
    assert 'role="alert"' in answer.text


@pytest.mark.slow
def test_guessing_passwords_is_rate_limited(site: Site) -> None:
    browser = site.browser()

    answers = [browser.post("/sign-in", {"name": "ann", "password": "x"}) for _ in range(11)]

    assert [answer.status_code for answer in answers] == [422] * 10 + [429]
    assert "Too many requests" in answers[-1].text


def test_a_token_is_shown_once_works_and_can_be_revoked(site: Site) -> None:
    browser = site.browser("ann")

    made = browser.post("/tokens", {"name": "laptop", "scopes": ["read"], "days": "7"}).text
    found = re.search(r"smk_[\w-]+", made.split('id="new-token"')[1])
    assert found is not None
    header = {"Authorization": f"Bearer {found.group()}"}
    before = site.browser().get("/api/v1/me", headers=header).status_code
    token_id = re.findall(r"/tokens/(\d+)/revoke", made)[0]
    after_page = browser.post(f"/tokens/{token_id}/revoke", follow_redirects=True).text

    assert before == 200
    assert found.group() not in after_page
    assert site.browser().get("/api/v1/me", headers=header).status_code == 401


def test_a_token_of_another_cannot_be_revoked(site: Site) -> None:
    made = site.browser("ann").post("/tokens", {"name": "laptop", "scopes": ["read"]}).text
    token_id = re.findall(r"/tokens/(\d+)/revoke", made)[0]

    assert site.browser("ben").post(f"/tokens/{token_id}/revoke").status_code == 404


def test_a_token_of_the_account_page_expires_within_a_year(site: Site) -> None:
    site.browser("ann").post("/tokens", {"name": "laptop", "scopes": ["read"], "days": "3650"})

    with site.database.reading() as session:
        token = session.scalars(select(Token)).one()
    assert token.expires_at is not None
    assert (token.expires_at - token.created_at) / 86_400 == pytest.approx(365)


def test_only_an_admin_can_create_a_token_with_admin_scope(site: Site) -> None:
    answer = site.browser("ann").post("/tokens", {"name": "x", "scopes": ["admin"]})

    assert answer.status_code == 422
    assert "cannot grant: admin" in answer.text


def test_the_cookie_is_http_only_and_same_site(site: Site) -> None:
    answer = site.browser().post("/sign-up", {"name": "cleo", "password": WORDS})

    cookie = answer.headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Lax" in cookie


@pytest.mark.slow
def test_the_runs_of_a_guest_move_to_the_account_at_sign_up_and_sign_in(site: Site) -> None:
    browser = site.browser()
    order = {"controller": "pi"}
    browser.post("/submit/currents-v1", order)
    words = {"name": "cleo", "password": "correct horse battery"}
    welcome = browser.post("/sign-up", words, follow_redirects=True)
    browser.post("/sign-out")
    browser.post("/submit/currents-v1", order)
    browser.post("/submit/currents-v1", order)
    back = browser.post("/sign-in", words, follow_redirects=True)

    assert "Find the run you started without an account" in welcome.text
    assert "Find the 2 runs you started without an account" in back.text
    views = [site.show(run_id) for run_id in (1, 2, 3)]
    assert [view.user for view in views] == ["cleo"] * 3
    assert "#1" in browser.get("/runs/").text


@pytest.mark.slow
def test_an_account_does_not_get_the_runs_of_another_guest(site: Site) -> None:
    site.browser().post("/submit/currents-v1", {"controller": "pi"})

    other = site.browser()
    other.post("/sign-up", {"name": "cleo", "password": "correct horse battery"})

    assert site.show(1).user_id is None


@pytest.mark.slow
def test_a_new_password_replaces_the_old_one_and_signs_other_browsers_out(site: Site) -> None:
    own, other = site.browser(), site.browser()
    own.post("/sign-up", {"name": "cleo", "password": WORDS})
    other.post("/sign-in", {"name": "cleo", "password": WORDS})

    answer = own.post("/password", {"old": WORDS, "new": "another horse battery"})

    assert answer.status_code == 302
    assert ">cleo<" in own.get("/").text
    assert ">cleo<" not in other.get("/").text
    for password, status in ((WORDS, 422), ("another horse battery", 302)):
        signed = site.browser().post("/sign-in", {"name": "cleo", "password": password})
        assert signed.status_code == status


@pytest.mark.slow
@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("wrong wrong wrong", "another horse battery", "current password is incorrect"),
        (WORDS, "short", "A password has"),
    ],
)
def test_a_password_change_needs_the_old_password_and_a_valid_new_one(
    site: Site, old: str, new: str, says: str
) -> None:
    browser = site.browser()
    browser.post("/sign-up", {"name": "cleo", "password": WORDS})

    answer = browser.post("/password", {"old": old, "new": new})

    assert (answer.status_code, says in answer.text) == (422, True)
    again = site.browser().post("/sign-in", {"name": "cleo", "password": WORDS})
    assert again.status_code == 302


def test_a_visitor_who_is_not_signed_in_cannot_change_a_password(site: Site) -> None:
    assert site.browser().post("/password", {"old": "", "new": WORDS}).status_code == 401


def test_a_copied_cookie_is_worth_nothing_after_signing_out(site: Site) -> None:
    browser, thief = site.browser(), site.browser()
    browser.post("/sign-up", {"name": "cleo", "password": WORDS})
    with browser.client.session_transaction() as own, thief.client.session_transaction() as copy:
        copy.update(own)
    assert ">cleo<" in thief.get("/").text

    browser.post("/sign-out")

    assert ">cleo<" not in thief.get("/").text


@pytest.mark.slow
def test_a_password_change_revokes_the_tokens(site: Site) -> None:
    browser = site.browser()
    browser.post("/sign-up", {"name": "cleo", "password": WORDS})
    with site.database.writing() as session:
        user = accounts.authenticate(session, "cleo", WORDS)
        assert user is not None
        text = accounts.new_token(session, user.id, "laptop", ["read"])

    browser.post("/password", {"old": WORDS, "new": "another horse battery"})

    with site.database.reading() as session:
        assert accounts.viewer_of_token(session, text) is None


def test_an_account_has_at_most_twenty_signed_in_browsers(site: Site) -> None:
    with site.app.app_context():
        cookies = [authentication.cookie_of(site.user_id("ann")) for _ in range(21)]

    def name_shown(cookie: dict[str, object]) -> bool:
        browser = site.browser()
        with browser.client.session_transaction() as session:
            session.update(cookie)
        return ">ann<" in browser.get("/").text

    assert [name_shown(cookie) for cookie in (cookies[0], cookies[1], cookies[20])] == [
        False,
        True,
        True,
    ]


@pytest.mark.slow
@pytest.mark.parametrize("target", ["/\r\nSet-Cookie: a=b", "/a\nb", "/a\0b", "/\u2028"])
def test_a_line_break_in_the_return_address_is_ignored(site: Site, target: str) -> None:
    browser = site.browser()
    browser.post("/sign-up", {"name": "cleo", "password": WORDS})

    answer = site.browser().post("/sign-in", {"name": "cleo", "password": WORDS, "next": target})

    assert answer.status_code in {302, 400}
    assert answer.headers.get("Location", "/") == "/"
    assert "a=b" not in str(answer.headers)


def _mode(site: Site, mode: str) -> Browser:
    """Return a browser of a service with this way to sign up."""
    current = site.app.extensions["seamark"]
    settings = current.settings.model_copy(update={"sign_up": mode})
    site.app.extensions["seamark"] = replace(current, settings=settings)
    return site.browser()


@pytest.mark.slow
def test_by_invitation_each_invitation_makes_one_account(site: Site) -> None:
    browser = _mode(site, "invitation")
    with site.database.writing() as session:
        (text,) = invitations.create(session, days=1.0)
        (expired,) = invitations.create(session, days=-1.0)
    assert f'value="{text}"' in browser.get(f"/sign-up?invitation={text}").text

    form = {"name": "cleo", "password": WORDS}
    tries = [{}, {"invitation": "guessed"}, {"invitation": expired}, {"invitation": text}]
    statuses = [site.browser().post("/sign-up", form | extra).status_code for extra in tries]
    again = site.browser().post("/sign-up", {**form, "name": "dora", "invitation": text})

    assert statuses == [422, 422, 422, 302]
    assert again.status_code == 422


def test_an_invitation_is_not_used_up_by_a_refused_name(site: Site) -> None:
    browser = _mode(site, "invitation")
    with site.database.writing() as session:
        (text,) = invitations.create(session, days=1.0)

    form = {"password": WORDS, "invitation": text}
    refused = browser.post("/sign-up", form | {"name": "1"})
    accepted = browser.post("/sign-up", form | {"name": "cleo"})

    assert (refused.status_code, accepted.status_code) == (422, 302)


def test_where_signing_up_is_closed_an_invitation_does_not_help(site: Site) -> None:
    browser = _mode(site, "closed")
    with site.database.writing() as session:
        (text,) = invitations.create(session, days=1.0)

    answer = browser.post("/sign-up", {"name": "cleo", "password": WORDS, "invitation": text})

    assert answer.status_code == 403

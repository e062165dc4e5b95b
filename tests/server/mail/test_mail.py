"""Addresses of accounts, the outbox, what is sent and when not."""

import time

import pytest
from click.testing import CliRunner
from sqlalchemy import select, update

from seamark.cli.main import cli
from seamark.server.accounts import accounts, password_resets
from seamark.server.database.mail_tables import MailAddress, OutgoingMail, RunNotice
from seamark.server.mail import addresses, outbox, sending, smtp
from seamark.server.mail.addresses import MailRejected
from seamark.server.mail.outbox import MailKind
from seamark.server.runs.ending import account_deletion
from tests.cast import Backend
from tests.server.mail.conftest import ANN, Post, age, long_run, rows
from tests.services.smtp import SITE

WORDS = "correct horse battery"


def ask_for_reset(post: Post, address: str) -> None:
    with post.database.writing() as session:
        addresses.request_reset(session, address)


def test_an_address_is_that_of_the_account_after_its_link_was_opened(post: Post) -> None:
    post.propose("ann", ANN)
    with post.database.reading() as session:
        before = addresses.of_account(session, post.user_id("ann"))
    post.send_all()

    with post.database.writing() as session:
        user = addresses.confirm(session, post.last_link())
        after = addresses.of_account(session, user.id)

    ((to, mail),) = post.inbox.received
    assert (before.address, before.pending) == (None, ANN)
    assert (user.name, after.address, after.pending) == ("ann", ANN, None)
    assert (to, mail["Subject"]) == (ANN, "Confirm your e-mail address")
    assert f"{SITE}/mail/confirm?link=" in mail.get_content()


def test_a_link_works_once_and_not_after_its_time(post: Post) -> None:
    post.confirm("ann", ANN)
    used = post.last_link()
    post.propose("ben", "ben@example.org")
    post.send_all()
    late = post.last_link()
    with post.database.writing() as session:
        session.execute(update(MailAddress).values(pending_until=time.time() - 1.0))

    for text in (used, late, "guessed"):
        with post.database.writing() as session, pytest.raises(MailRejected):
            addresses.confirm(session, text)


def test_the_link_to_an_earlier_address_no_longer_works(post: Post) -> None:
    post.propose("ann", "first@example.org")
    post.send_all()
    first = post.last_link()
    post.propose("ann", "second@example.org")

    with post.database.writing() as session, pytest.raises(MailRejected):
        addresses.confirm(session, first)


@pytest.mark.parametrize(
    "address",
    [
        "",
        "ann",
        "@example.org",
        "ann@",
        "a@b c",
        "a@b\r\nBcc: x@y",
        "a@b>,<c@d",
        "é@b.c",
        "a" * 255,
    ],
)
def test_what_is_no_address_is_refused(post: Post, address: str) -> None:
    with pytest.raises(MailRejected):
        post.propose("ann", address)
    with pytest.raises(MailRejected):
        ask_for_reset(post, address)


def test_a_line_break_never_gets_into_a_header(post: Post) -> None:
    with pytest.raises(ValueError, match="linefeed"):
        smtp.message(post.settings, "a@b.c", "Run\r\nBcc: x@y.z", "text")


@pytest.mark.slow
def test_a_forgotten_password_is_set_by_the_link_of_an_e_mail(post: Post) -> None:
    post.confirm("ann", ANN)

    ask_for_reset(post, "ann@EXAMPLE.org")
    post.send_all()
    with post.database.writing() as session:
        password_resets.use(session, post.last_link(), WORDS)

    with post.database.reading() as session:
        user = accounts.authenticate(session, "ann", WORDS)
    assert user is not None


def test_each_account_of_an_address_gets_a_link(post: Post) -> None:
    for name in ("ann", "ben"):
        post.confirm(name, ANN)

    ask_for_reset(post, ANN)
    post.send_all()

    text = post.last_text()
    assert ("ann: https" in text, "ben: https" in text, "eva" in text) == (True, True, False)


@pytest.mark.parametrize("state", ["unknown", "not confirmed", "disabled"])
def test_nobody_gets_a_link_for_an_address_that_is(post: Post, state: str) -> None:
    if state == "not confirmed":
        post.propose("ann", ANN)
        post.send_all()
    if state == "disabled":
        post.confirm("ann", ANN)
        with post.database.writing() as session:
            accounts.person(session, "ann").disabled_at = time.time()
    post.inbox.received.clear()

    ask_for_reset(post, ANN)
    post.send_all()

    assert post.inbox.received == []


def test_asking_for_a_known_and_an_unknown_address_writes_the_same(post: Post) -> None:
    post.confirm("ann", ANN)
    before = rows(post, OutgoingMail)
    added = []
    for address in (ANN, "nobody@example.org"):
        for _ in range(7):
            ask_for_reset(post, address)
            post.send_all()
        added.append(rows(post, OutgoingMail) - before)
        before = rows(post, OutgoingMail)

    # One of ann's five was the confirmation.
    assert added == [outbox.PER_HOUR - 1, outbox.PER_HOUR]


def test_an_address_gets_five_e_mails_in_an_hour(post: Post) -> None:
    for _ in range(outbox.PER_HOUR):
        post.propose("ann", ANN)
        post.send_all()

    with pytest.raises(MailRejected, match="in an hour"):
        post.propose("ben", ANN)
    assert len(post.inbox.received) == outbox.PER_HOUR
    age(post, 3601.0)
    post.propose("ben", ANN)


def test_removing_an_address_does_not_reset_what_was_sent_to_it(post: Post) -> None:
    for _ in range(outbox.PER_HOUR):
        post.propose("ann", ANN)
        post.send_all()
        with post.database.writing() as session:
            addresses.remove(session, post.user_id("ann"))

    with pytest.raises(MailRejected, match="in an hour"):
        post.propose("ann", ANN)


def test_the_outbox_is_bounded(post: Post, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(outbox, "WAITING_MAX", 3)

    for number in range(5):
        ask_for_reset(post, f"a{number}@example.org")

    assert rows(post, OutgoingMail) == 3


def test_an_e_mail_waits_while_the_server_is_away_and_is_given_up_after_a_day(post: Post) -> None:
    post.propose("ann", ANN)
    post.inbox.answer = "451 later"
    post.send_all()
    first = rows(post, OutgoingMail)
    age(post, 60.0)
    post.inbox.answer = "250 OK"
    post.send_all()
    delivered = len(post.inbox.received)

    post.propose("ben", "ben@example.org")
    post.inbox.answer = "451 later"
    age(post, outbox.GIVEN_UP_S)
    post.send_all()
    post.inbox.answer = "250 OK"
    age(post, 0.0)
    post.send_all()

    assert (first, delivered, len(post.inbox.received)) == (1, 1, 1)


def test_an_e_mail_that_the_server_refuses_is_not_tried_again(post: Post) -> None:
    post.propose("ann", ANN)
    post.inbox.answer = "554 no"
    post.send_all()
    post.inbox.answer = "250 OK"
    age(post, 60.0)
    post.send_all()

    assert post.inbox.received == []


def test_a_server_that_nobody_runs_delays_the_e_mail(post: Post) -> None:
    post.settings = post.settings.model_copy(update={"mail_url": "smtp://127.0.0.1:1?tls=none"})
    post.propose("ann", ANN)

    post.send_all()

    with post.database.reading() as session:
        (waiting,) = session.scalars(select(OutgoingMail))
    assert (waiting.tries, waiting.ended_at) == (1, None)
    assert waiting.next_try_at > time.time() + outbox.RETRY_S / 2


def test_no_password_and_no_e_mail_goes_to_a_server_without_the_tls_it_was_set_for(
    post: Post,
) -> None:
    url = post.settings.mail_url.replace("//", "//user:password@").removesuffix("?tls=none")
    post.settings = post.settings.model_copy(update={"mail_url": url})
    post.propose("ann", ANN)

    post.send_all()

    assert post.inbox.received == []


def test_of_two_senders_only_one_has_an_e_mail(both: Backend) -> None:
    with both.database.writing() as session:
        outbox.add(session, MailKind.RESET, outbox.hashed(ANN))
    with both.database.writing() as session:
        first = outbox.claim(session)
    with both.database.writing() as session:
        second = outbox.claim(session)

    assert first is not None
    assert (first.kind, first.tries, second) == (MailKind.RESET, 1, None)


def test_a_closed_account_leaves_no_address_and_gets_nothing(post: Post) -> None:
    post.confirm("ann", ANN)
    long_run(post, "ann")
    post.propose("ann", "new@example.org")
    post.inbox.received.clear()

    with post.database.writing() as session:
        account_deletion.close(session, post.user_id("ann"), keep_published=True)
    post.send_all()

    assert post.inbox.received == []
    assert (rows(post, MailAddress), rows(post, RunNotice)) == (0, 0)


@pytest.mark.parametrize(
    ("arguments", "changes", "code", "says"),
    [
        ((ANN, "--json"), {}, 0, '"sent": true'),
        (("ann",), {}, 2, "Enter an e-mail address"),
        ((ANN,), {"mail_url": "smtp://127.0.0.1:1?tls=none"}, 3, "Connection refused"),
        ((ANN,), {"mail_url": ""}, 2, "SEAMARK_MAIL_URL is not set"),
    ],
)
def test_an_operator_tries_the_mail_server(
    post: Post, arguments: tuple[str, ...], changes: dict[str, str], code: int, says: str
) -> None:
    environment = post.settings.model_copy(update=changes).environment()

    answer = CliRunner().invoke(cli, ["mail", "test", *arguments], env=environment)

    assert (answer.exit_code, says in answer.output) == (code, True)
    assert len(post.inbox.received) == (code == 0)


def test_the_sender_drops_what_nobody_needs_any_more(post: Post) -> None:
    post.propose("ann", ANN)
    with post.database.writing() as session:
        addresses.remove(session, post.user_id("ann"))

    post.send_all()

    assert not sending.send_next(post.database, post.settings, lambda _: None)
    assert post.inbox.received == []

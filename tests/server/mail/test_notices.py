"""E-mails about runs that have ended."""

import pytest

from seamark.server.database.mail_tables import RunNotice
from seamark.server.mail import addresses, notices
from seamark.server.mail.addresses import MailRejected
from tests.server.mail.conftest import ANN, Post, age, long_run, rows
from tests.services.smtp import SITE


def test_who_asked_for_it_is_told_of_a_run_that_took_long(post: Post) -> None:
    post.confirm("ann", ANN)
    post.inbox.received.clear()

    run_id = long_run(post, "ann", title="slow")
    post.send_all()
    post.send_all()

    ((to, mail),) = post.inbox.received
    body = mail.get_content()
    assert (to, mail["Subject"]) == (ANN, f"Run {run_id} succeeded")
    assert f"Run {run_id} “slow”, currents-v1: succeeded, score 50.000" in body
    assert f"{SITE}/runs/{run_id}" in body
    assert rows(post, RunNotice) == 0


def test_nobody_is_told_of_a_short_run_or_without_asking(post: Post) -> None:
    post.confirm("ann", ANN)
    post.confirm("ben", "ben@example.org")
    post.inbox.received.clear()

    long_run(post, "ann", minutes=29.0)
    post.succeeded("ben")
    cancelled = post.queue("ann")
    assert post.cancel(cancelled)
    post.send_all()

    assert (rows(post, RunNotice), post.inbox.received) == (0, [])


def test_many_runs_make_one_e_mail(post: Post, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notices, "LISTED_MAX", 2)
    post.confirm("ann", ANN)
    post.inbox.received.clear()

    first = long_run(post, "ann")
    post.send_all()
    others = [long_run(post, "ann") for _ in range(3)]
    post.send_all()
    soon = len(post.inbox.received)
    age(post, notices.EVERY_S)
    post.send_all()

    assert soon == 1
    assert f"Run {first}" in post.inbox.received[0][1]["Subject"]
    body = post.last_text()
    assert "3 of your runs have ended" in body
    assert f"Run {others[-1]}, " in body
    assert f"Run {others[0]}, " not in body
    assert "The other 1: " in body


def test_a_notice_is_repeated_when_the_server_was_away(post: Post) -> None:
    post.confirm("ann", ANN)
    post.inbox.received.clear()
    long_run(post, "ann")
    post.inbox.answer = "451 later"
    post.send_all()

    post.inbox.answer = "250 OK"
    age(post, 60.0)
    post.send_all()

    assert len(post.inbox.received) == 1


def test_no_notice_is_asked_for_without_a_confirmed_address(post: Post) -> None:
    post.propose("ann", ANN)

    with post.database.writing() as session, pytest.raises(MailRejected):
        addresses.set_notification(session, post.user_id("ann"), 30)


def test_a_title_of_a_run_adds_no_header_and_no_second_e_mail(post: Post) -> None:
    post.confirm("ann", ANN)
    long_run(post, "ann", title="x\r\n.\r\nMAIL FROM:<evil@x.y>")
    post.inbox.received.clear()

    post.send_all()

    ((to, mail),) = post.inbox.received
    assert (to, mail["Bcc"], "evil" in str(mail["From"])) == (ANN, None, False)
    assert ".\n" not in mail.get_content().splitlines(keepends=True)

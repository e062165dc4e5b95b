"""The process that sends e-mail."""

import os
import subprocess
import sys
import time

import pytest

from seamark.server.mail import addresses
from tests.cast import Backend
from tests.services import smtp


@pytest.mark.slow
def test_the_process_of_a_worker_sends_what_waits_and_ends_when_asked(backend: Backend) -> None:
    with smtp.server() as (inbox, url):
        with backend.database.writing() as session:
            addresses.propose(session, backend.user_id("ann"), "ann@example.org")
        environ = {key: text for key, text in os.environ.items() if not key.startswith("SEAMARK_")}
        environ |= smtp.with_mail(backend.settings, url).environment()
        module = ["-m", "seamark.worker.service.mail_sender", str(os.getpid())]

        with subprocess.Popen([sys.executable, "-s", "-P", *module], env=environ) as sender:
            deadline = time.monotonic() + 120.0
            while not inbox.received and time.monotonic() < deadline:
                time.sleep(0.05)
            sender.terminate()
            code = sender.wait(60.0)

    assert [to for to, _ in inbox.received] == ["ann@example.org"]
    assert code == 0

"""Neither an answer nor its time tells which accounts and private runs exist."""

import re
import time

import pytest

from seamark.server.accounts import accounts
from tests.conftest import HASHER_OF_SERVICE
from tests.server.pages.conftest import Site

WORDS = "correct horse battery"
REPEATS = 2
RATIO_MAX = 5.0  # without a verification it takes less than a hundredth of the time


def _cpu_s(site: Site, name: str, password: str) -> float:
    """Return the least CPU time of refusing a sign-in, which a busy machine does not change."""
    times = []
    with site.database.reading() as session:
        for _ in range(REPEATS):
            begin = time.process_time()
            assert accounts.authenticate(session, name, password) is None
            times.append(time.process_time() - begin)
    return min(times)


@pytest.mark.slow
def test_a_sign_in_is_as_much_work_for_every_name_and_password(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(accounts, "_hasher", HASHER_OF_SERVICE)
    with site.database.writing() as session:
        accounts.sign_up(session, "cleo", WORDS)
    known = _cpu_s(site, "cleo", "wrong wrong wrong")

    for name, password in (
        ("nobody", "wrong wrong wrong"),
        ("ann", "wrong wrong wrong"),  # has no password
        ("x" * 10_000, WORDS),
        ("cleo", "w" * 100_000),
    ):
        work = _cpu_s(site, name, password)
        assert known / RATIO_MAX < work < known * RATIO_MAX, name[:20]


@pytest.mark.slow
def test_a_private_run_and_one_that_does_not_exist_get_the_same_answer(site: Site) -> None:
    private = site.succeeded("ann")
    missing = private + 1
    browser = site.browser("ben")
    form = {"csrf_token": browser.csrf_token()}
    routes = [
        (rule, method)
        for rule in site.app.url_map.iter_rules()
        for method in sorted((rule.methods or set()) & {"GET", "POST", "DELETE"})
        if "run_id" in rule.arguments
    ]
    assert len(routes) > 20

    for rule, method in routes:
        answers = []
        for run_id in (private, missing):
            values = {"run_id": run_id, "role": "tracker", "name": "no-cup-v1"}
            built = rule.build(values, append_unknown=False)
            assert built is not None
            path = f"{built[1]}?with={run_id}"
            answer = browser.client.open(
                path, method=method, data=form, headers={"X-CSRFToken": form["csrf_token"]}
            )
            text = re.sub(rf"(runs/|run |with=){run_id}\b", "RUN", answer.text)
            text = re.sub(r'name="csrf_token" value="[^"]+"', "", text)
            answers.append((answer.status_code, text, {*answer.headers.keys()}))
        assert answers[0] == answers[1]
        assert answers[0][0] in {404, 415}  # 415: a form where the API takes JSON


@pytest.mark.parametrize("text", ["smk_unknown", "smk_", "", "é", "a" * 10_000])
def test_every_token_that_does_not_work_gets_the_same_answer(site: Site, text: str) -> None:
    with site.database.writing() as session:
        ann = site.user_id("ann")
        expired = accounts.new_token(session, ann, "old", ["read"], days=-1.0)

    def answer(token: str) -> tuple[int, str]:
        header = {"Authorization": f"Bearer {token}"}
        found = site.browser().get("/api/v1/me", headers=header)
        return found.status_code, found.text

    assert answer(text) == answer(expired)
    assert answer(text)[0] == 401

"""What admins see and decide on the pages below /admin."""

import re
from typing import Any

import pytest

from seamark.server.accounts import accounts, audit
from seamark.server.accounts.audit import AuditFilter
from seamark.server.database.tables import User, Worker
from seamark.server.messaging import workers
from seamark.server.runs.data import disk_usage
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission.quota import QuotaExceeded
from tests.server.pages.conftest import Site

WORDS = "correct horse battery"


def _log(site: Site, **wanted: str) -> list[tuple[str, str, str, dict[str, Any]]]:
    """Return actor, action, target and detail of the entries, newest first."""
    with site.database.reading() as session:
        entries = audit.page(session, AuditFilter(**wanted)).entries
    return [(each.actor, each.action, each.target, each.detail) for each in entries]


def _with_password(site: Site, name: str) -> None:
    with site.database.writing() as session:
        accounts.change_password(session, name, WORDS)


def _register(site: Site, name: str = "w1@host") -> None:
    with site.database.writing() as session:
        row = Worker(name=name, slots=2, level="strong", languages=["python"], findings=[])
        workers.register(session, row)


def _user(site: Site, name: str) -> User:
    with site.database.reading() as session:
        return accounts.person(session, name)


def test_only_an_admin_has_the_link_to_the_administration(site: Site) -> None:
    links = {
        who: '"/admin/"' in site.browser(who).get("/docs/start").text for who in ("olga", "root")
    }

    assert links == {"olga": False, "root": True}


def test_the_overview_says_that_no_worker_starts_runs(site: Site) -> None:
    without = site.browser("root").get("/admin/").text
    _register(site)

    assert "No worker starts runs" in without
    assert "Nothing needs attention" in site.browser("root").get("/admin/").text


def test_the_overview_counts_the_causes_of_failures(site: Site) -> None:
    site.failed({})
    site.succeeded("ben")

    page = site.browser("root").get("/admin/").text

    assert re.search(r"<dt>User error</dt><dd>1</dd>", page)
    assert re.search(r"<dt>Succeeded</dt><dd>1</dd>", page)


def test_a_worker_is_drained_and_resumed_on_its_page(site: Site) -> None:
    _register(site)
    run_id, root = site.running("ann").run_id, site.browser("root")
    site.queue("ben")

    root.post("/admin/workers/drain", {"worker": "w1@host"})
    drained = root.get("/admin/workers").text
    claimed = site.claim("w1@host/0")
    root.post("/admin/workers/resume", {"worker": "w1@host"})

    assert "drained" in drained
    assert claimed is None
    assert site.claim("w1@host/0") is not None
    assert site.show(run_id).state is RunState.RUNNING
    assert [entry[:3] for entry in _log(site)] == [
        ("root", "worker_resumed", "w1@host"),
        ("root", "worker_drained", "w1@host"),
    ]


def test_an_unknown_worker_is_not_drained(site: Site) -> None:
    answer = site.browser("root").post(
        "/admin/workers/drain", {"worker": "nowhere"}, follow_redirects=True
    )

    assert "not listed" in answer.text
    assert _log(site) == []


def test_the_runs_of_a_worker_are_on_its_card(site: Site) -> None:
    _register(site)
    run_id = site.queue("ann")
    assert site.claim("w1@host/1") is not None

    page = site.browser("root").get("/admin/workers").text

    assert f'href="/runs/{run_id}"' in page
    assert "1 of 2" in page


def test_users_are_found_by_a_part_of_the_name_the_role_and_whether_disabled(site: Site) -> None:
    root = site.browser("root")
    root.post(f"/admin/users/{site.user_id('ben')}/disable")

    def names(query: str) -> list[str]:
        return re.findall(r"<bdi>(\w+)</bdi></a></th>", root.get(f"/admin/users?{query}").text)

    assert names("q=N") == ["ben", "ann"]
    assert names("role=teacher") == ["tim"]
    assert names("disabled=on") == ["ben"]
    assert names("q=%25") == []


@pytest.mark.slow
def test_a_disabled_account_is_refused_at_once_and_comes_back(site: Site) -> None:
    _with_password(site, "ann")
    with site.database.writing() as session:
        token = accounts.new_token(session, site.user_id("ann"), "t", ["read"])
    account = f"/admin/users/{site.user_id('ann')}"
    site.sign_in("ann")
    cookie = site.browser("ann")
    headers = {"Authorization": f"Bearer {token}"}
    queued, running = site.queue("ann"), site.claim_next()

    def statuses() -> list[int]:
        signed_in = site.browser().post("/sign-in", {"name": "ann", "password": WORDS})
        by_token = site.browser().get("/api/v1/tokens", headers=headers)
        return [signed_in.status_code, by_token.status_code, cookie.get("/tokens").status_code]

    before = statuses()
    site.browser("root").post(f"{account}/disable")
    disabled = statuses()
    site.browser("root").post(f"{account}/enable")

    assert before == [302, 200, 200]
    assert disabled == [403, 401, 302]
    assert statuses() == before
    assert queued == running.run_id
    assert site.show(queued).state is RunState.CANCELLED
    assert _log(site, target="ann")[1] == ("root", "account_disabled", "ann", {"cancelled_runs": 1})


def test_a_quota_of_ones_own_counts_instead_of_the_setting(site: Site) -> None:
    account = f"/admin/users/{site.user_id('ann')}"
    site.browser("root").post(account, {"role": "user", "quota_day": "0"})
    with pytest.raises(QuotaExceeded, match="the limit"):
        site.queue("ann")

    site.browser("root").post(account, {"role": "user", "quota_day": ""})

    assert site.queue("ann")
    assert [entry[3] for entry in _log(site, target="ann")] == [
        {"from": 0, "to": None},
        {"from": None, "to": 0},
    ]


@pytest.mark.slow
@pytest.mark.parametrize("number", ["-1", "1e3", "x", "100001", "9" * 40])
def test_a_quota_that_is_no_sensible_number_is_refused(site: Site, number: str) -> None:
    account = f"/admin/users/{site.user_id('ann')}"

    answer = site.browser("root").post(account, {"quota_day": number})

    assert answer.status_code == 422
    assert _user(site, "ann").quota_day is None


def test_a_new_role_counts_at_once(site: Site) -> None:
    site.browser("root").post(f"/admin/users/{site.user_id('ann')}", {"role": "teacher"})

    assert site.browser("ann").get("/invitations").status_code == 200
    assert _log(site)[0] == ("root", "role_changed", "ann", {"from": "user", "to": "teacher"})


@pytest.mark.parametrize(
    ("path", "form"),
    [("", {"role": "user"}), ("/disable", {}), ("/delete", {"confirm": "root"})],
)
def test_an_admin_cannot_lock_the_own_account(site: Site, path: str, form: dict[str, str]) -> None:
    answer = site.browser("root").post(f"/admin/users/{site.user_id('root')}{path}", form)

    assert answer.status_code == 422
    assert site.browser("root").get("/admin/").status_code == 200
    assert _log(site) == []


@pytest.mark.slow
def test_a_link_for_a_new_password_is_shown_once_and_works(site: Site) -> None:
    answer = site.browser("root").post(f"/admin/users/{site.user_id('ann')}/reset")
    (link,) = re.findall(r"/reset\?link=([\w-]+)", answer.text)

    site.browser().post("/reset", {"link": link, "new": WORDS})

    signed_in = site.browser().post("/sign-in", {"name": "ann", "password": WORDS})
    assert signed_in.status_code == 302
    assert [entry[1] for entry in _log(site)] == ["password_changed", "reset_link_made"]
    assert link not in str(_log(site))


def test_revoked_access_ends_browsers_and_tokens(site: Site) -> None:
    ann = site.browser("ann")
    assert ann.get("/account").status_code == 200

    site.browser("root").post(f"/admin/users/{site.user_id('ann')}/revoke")

    assert ann.get("/account").status_code == 302


def test_an_account_is_deleted_after_its_name_has_been_typed(site: Site) -> None:
    account = f"/admin/users/{site.user_id('ann')}"
    wrong = site.browser("root").post(f"{account}/delete", {"confirm": "an"})

    site.browser("root").post(f"{account}/delete", {"confirm": "ann"})

    assert wrong.status_code == 422
    assert site.browser("root").get(account).status_code == 404
    assert _log(site)[0] == ("root", "account_deleted", "ann", {"keep_published": False})


def test_who_publishes_and_withdraws_is_in_the_log_with_the_address(site: Site) -> None:
    run_id, ann = site.succeeded("ann"), site.browser("ann")
    ann.post(f"/runs/{run_id}/publish")
    ann.post(f"/runs/{run_id}/publish")
    site.browser("root").post(f"/runs/{run_id}/withdraw")

    assert [entry[:3] for entry in _log(site)] == [
        ("root", "run_withdrawn", f"run {run_id}"),
        ("ann", "run_published", f"run {run_id}"),
    ]
    page = site.browser("root").get(f"/admin/audit?actor=ann&target=run+{run_id}").text
    assert "127.0.0.1" in page
    assert "Run withdrawn</td>" not in page


def _until_blocked(site: Site, name: str) -> None:
    """Type wrong passwords until one more is refused: by the minute, or on a slow machine by 20."""
    form = {"name": name, "password": "wrong password"}
    statuses = (site.browser().post("/sign-in", form).status_code for _ in range(21))
    assert 429 in statuses


@pytest.mark.slow
def test_blocked_sign_ins_are_in_the_log_once_and_without_what_was_typed(site: Site) -> None:
    for name in ("ann", "ann", "my secret words"):
        _until_blocked(site, name)

    assert _log(site) == [
        ("anonymous", "sign_in_blocked", "", {}),
        ("anonymous", "sign_in_blocked", "ann", {}),
    ]


def test_the_queue_is_listed_in_the_order_in_which_runs_start_and_with_their_workers(
    site: Site,
) -> None:
    _register(site)
    running = site.running("ann").run_id
    waiting = [site.queue(who) for who in ("ann", "ben", "guest")]

    page = site.browser("root").get("/admin/queue").text
    numbers = [int(number) for number in re.findall(r'<a href="/runs/(\d+)">#', page)]

    assert numbers == [running, waiting[1], waiting[0], waiting[2]]
    assert "Waiting: 3" in page


def test_an_admin_cancels_a_queued_run_of_somebody_else_which_is_logged(site: Site) -> None:
    run_id, root = site.queue("ann"), site.browser("root")

    answers = [
        root.post("/admin/queue/cancel", {"run": run}, follow_redirects=True).text
        for run in (run_id, run_id)
    ]

    assert site.show(run_id).state is RunState.CANCELLED
    assert f"Run #{run_id} is cancelled." in answers[0]
    assert f"Run #{run_id} had already ended." in answers[1]
    assert _log(site) == [("root", "run_cancelled", f"run {run_id}", {})]


def test_who_cancels_an_own_run_leaves_no_entry(site: Site) -> None:
    run_id = site.queue("ann")

    site.browser("ann").post(f"/runs/{run_id}/cancel")

    assert site.show(run_id).state is RunState.CANCELLED
    assert _log(site) == []


@pytest.mark.slow
def test_the_storage_page_shows_a_measurement_and_asks_a_worker_to_delete(site: Site) -> None:
    root, path = site.browser("root"), "/admin/storage"
    site.succeeded("ann", controller="upload", program=site.store_program())
    before = root.get(path).text
    disk_usage.measure(site.database, site.settings)

    measured = root.get(path).text
    answer = root.post(f"{path}/retention", follow_redirects=True).text

    assert "Nothing has been measured yet" in before
    assert re.search(r"Uploaded programs</th>.*?1 file<", measured)
    assert "a worker begins within seconds" in answer
    assert "Delete what is due now" not in answer
    assert _log(site) == [("root", "retention_requested", "", {})]

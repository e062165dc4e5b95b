"""Guests of the API: what they may do, see and use up."""

import io

import pytest

from tests.server.api.conftest import Site

RUNS = "/api/v1/runs"


def test_a_guest_can_run_a_built_in_controller_and_see_it_later(site: Site) -> None:
    browser = site.client()

    ordered = browser.post(RUNS, json={"benchmark": "currents-v1", "controller": "p"})

    assert ordered.status_code == 202
    assert browser.get(ordered.headers["Location"]).get_json()["state"] == "queued"
    assert site.client().get(ordered.headers["Location"]).status_code == 404


@pytest.mark.slow
def test_orders_without_a_cookie_share_the_quota_of_their_network(site: Site) -> None:
    order = {"benchmark": "currents-v1", "controller": "p"}

    def status(address: str) -> int:
        client = site.app.test_client(use_cookies=False)
        return client.post(RUNS, json=order, environ_base={"REMOTE_ADDR": address}).status_code

    one_by_one = [status(f"192.0.2.{number}") for number in range(site.settings.quota_live + 1)]
    of_six = [status(f"2001:db8:1:{number:x}::1") for number in range(site.settings.quota_live + 1)]

    assert one_by_one == of_six == [202] * site.settings.quota_live + [429]
    assert status("198.51.100.1") == status("2001:db8:2::1") == 202


def test_guests_of_one_network_do_not_see_each_others_runs(site: Site) -> None:
    first, second = site.client(), site.client()
    for browser in (first, second):
        browser.post(RUNS, json={"benchmark": "currents-v1", "controller": "p"})

    own = [[run["id"] for run in each.get(RUNS).get_json()["runs"]] for each in (first, second)]

    assert own == [[1], [2]]
    assert first.get(f"{RUNS}/2").status_code == 404


def test_a_guest_cannot_upload_a_program(site: Site) -> None:
    form = {"run": '{"benchmark": "currents-v1"}', "program": (io.BytesIO(b"x"), "c.py")}

    answer = site.client().post(RUNS, data=form)

    assert answer.status_code == 403
    assert answer.get_json()["type"] == "/problems/account-needed"

"""The page of a comparison, and how to get there."""

import re
from typing import Any

from seamark.server.database.tables import User
from seamark.server.programs.vehicles import StoredVehicle
from tests.server.pages.conftest import Site

SHORT = {"levels": [0.1, 0.3], "level_duration_s": 4.0, "settle_s": 1.0}


def _marked(site: Site) -> int:
    """Return the public run of a reference entry of currents-v1."""
    site.sign_up("mark")
    with site.database.writing() as session:
        session.get_one(User, site.user_id("mark")).is_baseline = True
    return site.succeeded("mark", kind="ranked", title="PI, default settings")


def _practised(
    site: Site, who: str = "ann", *, sent: StoredVehicle | None = None, **config: Any
) -> int:
    return site.succeeded(who, seed=7, config=SHORT | config, vehicle=sent)


def test_two_runs_are_shown_with_what_differs(site: Site) -> None:
    first, second = _practised(site, kp=0.4), _practised(site, kp=0.6)

    page = site.browser("ann").get(f"/compare?runs={first},{second}").text

    assert "Compare 2 runs" in page
    assert "Settings that differ" in page
    assert (">0.4<" in page, ">0.6<" in page) == (True, True)
    assert "in the same conditions" in page


def test_runs_with_a_vehicle_of_ones_own_are_compared_by_all_of_its_thrusters(site: Site) -> None:
    vehicle = site.store_vehicle()
    own = [_practised(site, vehicle=vehicle.name, sent=vehicle) for _ in range(2)]
    ours = _practised(site)
    browser = site.browser("ann")

    both = browser.get(f"/compare?runs={own[0]},{own[1]}").text
    mixed = browser.get(f"/compare?runs={own[0]},{ours}").text

    charted = [set(re.findall(r'"column": ?"(thrust_\d)"', page)) for page in (both, mixed)]
    assert [len(names) for names in charted] == [8, 5]
    assert (f">{vehicle.name}<" in mixed, ">Girona 500" in mixed) == (True, True)


def test_the_boxes_of_a_list_lead_to_the_one_address_of_a_comparison(site: Site) -> None:
    ids = [_practised(site) for _ in range(3)]
    browser = site.browser("ann")

    answer = browser.get(f"/compare?runs={ids[0]}&runs={ids[1]}, {ids[2]}&runs=&runs={ids[0]}")

    assert (answer.status_code, answer.location) == (
        303,
        f"/compare?runs={ids[0]},{ids[1]},{ids[2]}",
    )


def test_the_reference_entries_are_offered_to_be_compared_with(site: Site) -> None:
    mark, run_id = _marked(site), _practised(site)
    browser = site.browser("ann")

    choice = browser.get(f"/compare?runs={run_id}").text
    comparison = browser.get(f"/compare?runs={run_id},{_practised(site)}").text
    nothing_chosen = browser.get("/compare?benchmark=currents-v1").text

    for page in (choice, comparison, nothing_chosen):
        assert f'name="runs" value="{mark}"' in page
        assert "PI, default settings" in page


def test_lists_and_runs_lead_to_a_comparison(site: Site) -> None:
    run_id, mark = _practised(site), _marked(site)
    browser = site.browser("ann")

    runs, board = browser.get("/runs/").text, browser.get("/leaderboards/currents-v1").text

    assert f'name="runs" value="{run_id}"' in runs
    assert f'name="runs" value="{mark}"' in board
    assert f'href="/compare?runs={run_id}"' in browser.get(f"/runs/{run_id}").text


def test_only_runs_that_the_viewer_may_see_are_offered_and_compared(site: Site) -> None:
    private = _practised(site)
    mark = _marked(site)
    stranger = site.browser("ben")

    offered = stranger.get(f"/compare?runs={mark}").text

    assert f'value="{private}"' not in offered
    assert stranger.get(f"/compare?runs={mark},{private}").status_code == 404
    assert stranger.get(f"/compare?runs={private}").status_code == 404


def test_too_many_runs_and_words_are_refused_with_what_to_do(site: Site) -> None:
    browser = site.browser("ann")

    too_many = browser.get("/compare?runs=1,2,3,4,5,6")
    words = browser.get("/compare?runs=best")

    assert (too_many.status_code, words.status_code) == (422, 422)
    assert "At most 5 runs" in too_many.text
    assert "such as 12,17" in words.text


def test_runs_of_different_benchmarks_say_what_cannot_be_compared(site: Site) -> None:
    first, second = _practised(site), site.succeeded("ann", benchmark="currents-v2")

    page = site.browser("ann").get(f"/compare?runs={first},{second}").text

    assert "their scores and metrics cannot" in page


def _of_program(site: Site, source: bytes, who: str = "ann") -> int:
    program = site.store_program(source)
    return site.succeeded(who, seed=7, controller="upload", program=program)


GAIN = b"""class Controller:
    def __init__(self, config):
        self.kp = %s

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
"""


def test_the_lines_in_which_programs_differ_are_shown_to_their_owner(site: Site) -> None:
    first, second = _of_program(site, GAIN % b"0.4"), _of_program(site, GAIN % b"0.5")

    page = site.browser("ann").get(f"/compare?runs={first},{second}").text

    assert f"Run {second} compared with run {first}" in page
    assert "<del>−         self.kp = 0.4\n</del>" in page
    assert "<ins>+         self.kp = 0.5\n</ins>" in page
    assert "SHA-256" not in page


def test_a_program_that_was_not_published_is_only_said_to_differ(site: Site) -> None:
    open_run, closed = _of_program(site, GAIN % b"0.4"), _of_program(site, GAIN % b"0.5")
    same = _of_program(site, GAIN % b"0.5")
    site.publish(open_run)
    for run_id in (closed, same):
        site.publish(run_id, program=False)

    page = site.browser("ben").get(f"/compare?runs={open_run},{closed}").text
    equal = site.browser("ben").get(f"/compare?runs={closed},{same}").text
    owners = site.browser("ann").get(f"/compare?runs={open_run},{closed}").text

    assert f"The owner of run {closed} did not publish the source." in page
    assert "self.kp" not in page
    assert "The programs are the same." in equal
    assert "self.kp" not in equal
    assert "self.kp = 0.5" in owners


def test_a_program_is_escaped_where_it_is_shown(site: Site) -> None:
    first, second = _of_program(site, GAIN % b"0.4"), _of_program(site, GAIN % b"'<script>'")

    page = site.browser("ann").get(f"/compare?runs={first},{second}").text

    assert "self.kp = &#39;&lt;script&gt;&#39;" in page


def test_a_program_that_was_deleted_is_said_to_be(site: Site) -> None:
    first, second = _of_program(site, GAIN % b"0.4"), _of_program(site, GAIN % b"0.5")
    for file in (site.settings.data / "programs").iterdir():
        file.unlink()

    page = site.browser("ann").get(f"/compare?runs={first},{second}").text

    assert "One of them was deleted." in page


def test_distances_in_metres_come_first_where_the_task_is_to_hold_a_station(site: Site) -> None:
    runs = [_practised(site), _practised(site)]
    tracked = [
        site.succeeded("ann", benchmark="visibility-v2", controller="built-in") for _ in runs
    ]
    browser = site.browser("ann")

    pages = [browser.get(f"/compare?runs={a},{b}").text for a, b in (runs, tracked)]

    first = [re.search(r'"charts": ?\[\{"column": ?"([a-z_]+)"', page) for page in pages]
    assert [found and found[1] for found in first] == ["distance", "tracker_error"]

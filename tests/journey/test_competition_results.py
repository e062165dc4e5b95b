"""A final that the service itself decides, and what a spectator sees of it in a real browser."""

import time
from collections.abc import Callable

import pytest
from playwright.sync_api import expect

from seamark.server.accounts.permissions import Role
from seamark.server.database.engine import Database
from seamark.server.database.tables import Run
from seamark.server.judging import check
from seamark.server.runs.record.states import RunState
from seamark.server.settings import Settings
from tests.cast import Backend
from tests.journey import accessibility
from tests.journey.conftest import SHORT
from tests.journey.service import Service
from tests.journey.visitor import Visitor
from tests.server.judging.cup import DAY_S, FINAL, Cup, round_of

pytestmark = [pytest.mark.browser, pytest.mark.host, pytest.mark.slow]

NAME, TITLE = "results-cup-v1", "Cup of Kelp and Wrack"  # on a service that has other ones
WITHIN_S = 240.0
ROUNDS = [
    round_of("practice", -2 * DAY_S, -DAY_S, trials=2),
    round_of("qualification", -DAY_S, DAY_S, trials=2),
    round_of("final", 2 * DAY_S, None, trials=4, batches=1),
]


def wait_until(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + WITHIN_S
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.5)


def decided(service: Service) -> Cup:
    """Hold a competition of two teams, whose runs the worker of the service evaluates."""
    settings = Settings.model_validate(
        {
            "data": service.data,
            "database_url": f"sqlite:///{service.data / 'seamark.db'}",
            "seed_key": (service.data / "seed_key").read_text().strip(),
        }
    )
    backend = Backend(Database(settings.database_url), settings, {})
    backend.sign_up("olga", role=Role.ORGANISER)
    cup = Cup.draft(backend, name=NAME, title=TITLE, settings=SHORT, rounds=ROUNDS)
    with backend.database.writing() as session:
        check.request(session, cup.view, settings)

    def is_checked() -> bool:
        with backend.database.reading() as session:
            return check.view(session, cup.view).has_ended

    wait_until(is_checked)
    cup.shift(1, closes_in_s=DAY_S)
    with backend.database.writing() as session:
        check.open_up(session, cup.view)
    cup.shift(1, closes_in_s=0.0)
    entries = []
    for name, controller in (("kelp", "pi"), ("wrack", "p")):
        backend.sign_up(name)
        cup.team(name, name=name.title())
        entries.append(cup.submit(name, f"{controller} of {name}", controller=controller))

    def have_ended() -> bool:
        with backend.database.reading() as session:
            states = [session.get_one(Run, run_id).state for run_id in entries]
        return states == [RunState.SUCCEEDED] * len(states)

    wait_until(have_ended)
    cup.close_qualification()
    cup.shift(FINAL, opens_in_s=0.0)
    wait_until(lambda: cup.view.ended_at is not None)
    return cup


def test_a_spectator_watches_the_podium_of_a_final_that_the_service_decided(
    service: Service, reader: Visitor
) -> None:
    cup = decided(service)
    page, rows = reader.page, cup.board(FINAL).rows
    reader.open("/competitions/")
    page.get_by_role("link", name=TITLE).click()
    page.get_by_role("link", name="Results").click()

    places = page.get_by_role("list", name="Podium").get_by_role("listitem")
    expect(places).to_have_count(2)
    expect(places.first).to_contain_text(rows[0].team)
    for row in rows:
        image = page.locator(f'[data-view="{row.run_id}"] img')
        expect(image).to_be_visible(timeout=60_000)
        name = f"#{row.run_id} {row.team}: {row.method}"
        expect(page.get_by_role("link", name=name)).to_be_visible()
    expect(page.locator("[data-level-curves] .chart")).to_have_count(1)
    page.get_by_text("Certificates").click()
    page.get_by_role("link", name=f"Place 1: {rows[0].team}").click()
    expect(page.get_by_text("Place 1", exact=True)).to_be_visible()
    page.go_back()
    assert list(accessibility.defects(page)) == []
    assert (reader.errors, reader.violations()) == ([], [])

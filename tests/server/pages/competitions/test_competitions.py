"""Competitions as everybody sees them, with and without an account."""

import re
import time

import pytest

from seamark.server.competitions import competitions
from seamark.server.judging.boards import Board, BoardRow
from seamark.server.pages.competitions.shown_board import shown_board
from tests.server.judging.cup import DAY_S, FINAL, NAME, PRACTICE, QUALIFICATION, Cup, round_of
from tests.server.pages.conftest import Site

PAGE = f"/competitions/{NAME}"
MARKUP = "<b>bold</b>"


def _row(*, team: int | None, score: float) -> BoardRow:
    return BoardRow(
        place=None,
        place_low=None,
        place_high=None,
        team_id=team,
        team="",
        method="M",
        run_id=1,
        score=score,
        low=None,
        high=None,
        submitted_at=0.0,
    )


def test_everybody_sees_an_open_competition_in_the_list_and_nobody_but_its_organiser_a_draft(
    site: Site,
) -> None:
    Cup.opened(site, title="Open Cup", name="open-cup-v1")
    Cup.draft(site, title="Secret Cup", name="secret-cup-v1")

    pages = {who: site.browser(who).get("/competitions/").text for who in ("stranger", "ann")}
    own = site.browser("olga").get("/competitions/").text
    statuses = {
        who: site.browser(who).get("/competitions/secret-cup-v1").status_code
        for who in ("stranger", "ann", "tim", "olga")
    }

    assert all("Open Cup" in page and "Secret Cup" not in page for page in pages.values())
    assert "Secret Cup" in own
    assert "Qualification is open, closes in" in own
    assert statuses == {"stranger": 404, "ann": 404, "tim": 404, "olga": 200}


def test_what_an_organiser_writes_is_text_not_markup(site: Site) -> None:
    Cup.opened(site, title=MARKUP, question=MARKUP, rules=f"{MARKUP}\n\nSecond.")

    for path in (PAGE, "/competitions/"):
        page = site.browser().get(path).text
        assert MARKUP not in page
        assert "&lt;b&gt;bold&lt;/b&gt;" in page


def test_a_page_says_what_differs_from_the_benchmark_and_all_rules(site: Site) -> None:
    Cup.opened(site, programs="organiser", ties="shared", team_size=1, methods=2)

    page = site.browser().get(PAGE).text

    assert re.search(r"<dt>Current levels \[m/s\]</dt><dd>0, 0.2</dd>", page)
    assert "Who keeps station in a harbour?" in page
    assert "A team has up to 1 member and 2 methods." in page
    assert "The organiser may read the programs that you submit" in page
    assert "share a place" in page
    assert "3 submissions of a team, 3 trials each" in page
    assert "up to 2 batches of 6 trials, 1 method of a team, the best" in page


def test_times_are_in_the_zone_of_the_competition_and_in_utc_for_the_readers_browser(
    site: Site,
) -> None:
    cup = Cup.opened(site)
    with site.database.writing() as session:
        competitions.move_round(session, cup.view, FINAL, 1_800_000_000.0, "Rain <b>")

    page = site.browser().get(PAGE).text

    assert (
        '<time datetime="2027-01-15T08:00:00+00:00" data-zone="Europe/Madrid">'
        "Fri 15 Jan 2027, 09:00</time>"
    ) in page
    assert "The organiser moved the beginning of round 3 from" in page
    assert "“<bdi>Rain &lt;b&gt;</bdi>”" in page


def test_commitments_are_shown_from_the_start_and_keys_when_their_round_is_decided(
    site: Site,
) -> None:
    cup = Cup.opened(site)
    before = site.browser().get(PAGE).text
    cup.shift(PRACTICE, closes_in_s=-10.0)
    cup.advance()

    after = site.browser().get(PAGE).text

    practice, *others = cup.view.rounds
    assert all(one.commitment in before for one in cup.view.rounds)
    assert practice.key is not None
    assert practice.key not in before
    assert practice.key in after
    assert after.count("key not revealed yet") == len(others)


def test_a_team_sees_its_place_its_marked_row_and_how_many_submissions_it_has_left(
    site: Site,
) -> None:
    cup = Cup.opened(site)
    cup.team("ann", name="Kelp <b>")
    cup.team("eva")
    cup.entered("eva", [50.0, 51.0, 52.0])
    cup.entered("ann", [40.0, 41.0, 42.0])

    own, others = site.browser("ann").get(PAGE).text, site.browser().get(PAGE).text

    assert "<strong>place 2 of 2</strong>" in own
    assert "It has 2 of 3 submissions left in round 2." in own
    assert re.search(r'<tr class="mine">.*?<bdi>Kelp &lt;b&gt;</bdi> <small>your team', own)
    assert "Kelp &lt;b&gt;" in others
    assert "<small>your team" not in others
    assert "place 2 of 2" not in others


def test_a_board_has_a_row_per_team_or_per_method_with_the_marks_between_them(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann")
    cup.entered("ann", [40.0, 41.0, 42.0], method="Slow")
    cup.entered("ann", [50.0, 51.0, 52.0], method="Fast")

    teams = site.browser().get(PAGE).text
    methods = site.browser().get(f"{PAGE}?per=method").text

    assert ("Fast" in teams, "Slow" in teams) == (True, False)
    assert methods.index("Fast") < methods.index("Slow")
    assert teams.count(">reference</span>") == len(cup.asked.base.baselines)


def test_a_hidden_board_is_for_the_organiser_alone_until_its_round_is_decided(site: Site) -> None:
    hidden = round_of("qualification", -DAY_S, DAY_S, trials=3, quota=3, board="hidden")
    cup = Cup.opened(site, rounds=[hidden])
    cup.team("ann", name="Kelp")
    cup.entered("ann", [40.0, 41.0, 42.0])

    before = {who: site.browser(who).get(PAGE).text for who in ("stranger", "ann", "olga")}
    cup.shift(1, closes_in_s=-1.0)
    cup.advance()
    after = site.browser().get(PAGE).text

    assert {who: "41.00" in page for who, page in before.items()} == {
        "stranger": False,
        "ann": False,
        "olga": True,
    }
    assert "is hidden until the round is decided" in before["ann"]
    assert "41.00" in after


def test_nobody_sees_a_score_of_a_final_before_it_is_decided(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", name="Kelp")
    cup.team("eva", name="Wrack")
    for who, method in (("ann", "One"), ("eva", "Two")):
        cup.entered(who, [40.0, 41.0, 42.0], method=method)
    cup.begin_final()
    scores = {"One": [81.0, 82.0, 83.0] * 2, "Two": [71.0, 72.0, 73.0] * 2}
    cup.play_batch(scores)

    during = site.browser("olga").get(f"{PAGE}?round=3").text
    for _ in range(3):
        cup.advance()
        cup.play_batch(scores)
    after = site.browser().get(PAGE).text

    assert "Nobody sees its scores before it is decided" in during
    assert "82.00" not in during
    assert cup.view.ended_at is not None
    assert after.index("82.00") < after.index("72.00")
    assert "<strong>Decided</strong>" in after


@pytest.mark.parametrize("address", ["?round=9", "?round=x", "?from=-1", "?from=99999999"])
def test_an_address_with_a_wrong_number_shows_the_round_that_is_open(
    site: Site, address: str
) -> None:
    Cup.opened(site)

    page = site.browser().get(PAGE + address)

    assert page.status_code == 200
    assert f'round={QUALIFICATION}" aria-current="true"' in page.text


def test_a_long_board_has_pages_and_no_row_is_lost_between_them() -> None:
    rows = tuple(_row(team=number, score=200.0 - number) for number in range(150))
    board = Board(rows, (_row(team=None, score=150.5),), by_method=False)

    first = shown_board(board, 120, 0)
    assert first.next is not None
    second = shown_board(board, 120, first.next)

    scores = [each.score for each in (*first.rows, *second.rows)]
    assert scores == sorted([*(200.0 - number for number in range(150)), 150.5], reverse=True)
    assert second.next is None
    assert [row.team_id for row in second.own] == [120]
    assert [each.row.team_id for each in second.rows if each.is_own] == [120]


def test_only_while_the_qualification_is_open_is_anybody_invited_to_take_part(site: Site) -> None:
    cup = Cup.opened(site)
    before = site.browser().get(PAGE).text
    cup.close_qualification()

    after = site.browser().get(PAGE).text

    assert 'id="enter"' in before
    assert f'href="/sign-in?next={PAGE}"' in before
    assert 'id="enter"' not in after
    assert time.time() > (cup.view.qualification.closes_at or 0.0)

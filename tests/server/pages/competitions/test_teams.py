"""Teams: who founds, joins, changes and leaves one, and what they see of their entries."""

import re

import pytest

from seamark.programs.failure_reasons import FailureReason
from seamark.server.competitions import teams
from seamark.server.competitions.teams import TeamView
from seamark.server.judging import entries
from tests.server.judging.cup import DAY_S, NAME, Cup, round_of
from tests.server.pages.conftest import Site

PAGE = f"/competitions/{NAME}"
TEAM = f"{PAGE}/team"
AGREED = {"agreed": "on"}


def team_of(site: Site, cup: Cup, who: str) -> TeamView | None:
    with site.database.reading() as session:
        return teams.of_user(session, cup.id, site.user_id(who))


def link_of(site: Site, who: str) -> str:
    found = re.search(r"http://localhost(/competitions/[\w-]+/join/[\w-]+)", page_of(site, who))
    assert found is not None
    return found[1]


def page_of(site: Site, who: str) -> str:
    answer = site.browser(who).get(TEAM)
    assert answer.status_code == 200
    return answer.text


def test_a_captain_founds_a_team_and_another_joins_it_by_its_link(site: Site) -> None:
    cup = Cup.opened(site)
    founded = site.browser("ann").post(f"{PAGE}/teams", {"team": "Kelp <b>"} | AGREED)
    link = link_of(site, "ann")

    offered = site.browser("ben").get(link).text
    joined = site.browser("ben").post(f"{PAGE}/join", {"code": link} | AGREED)

    assert founded.headers["Location"] == joined.headers["Location"] == TEAM
    assert "<bdi>Kelp &lt;b&gt;</bdi>" in offered
    team = team_of(site, cup, "ben")
    assert team is not None
    assert [member.name for member in team.members] == ["ann", "ben"]
    assert team.captain_id == site.user_id("ann")
    assert site.browser("ben").get(link).headers["Location"] == TEAM


@pytest.mark.parametrize("programs", ["hidden", "organiser", "public"])
def test_nobody_enters_without_agreeing_on_the_rules_and_on_who_reads_programs(
    site: Site, programs: str
) -> None:
    cup = Cup.opened(site, programs=programs)
    cup.team("ann")
    link = link_of(site, "ann")
    ben = site.browser("ben")

    pages = [ben.get(PAGE).text, ben.get(link).text]
    refused = [
        ben.post(f"{PAGE}/teams", {"team": "Mine"}),
        ben.post(f"{PAGE}/join", {"code": link}),
    ]

    for page in pages:
        box = re.search(r'name="agreed" required>\s*<span>(.*?)</span>', page)
        assert box is not None
        assert ("organiser may read" in box[1]) == (programs != "hidden")
    assert [answer.status_code for answer in refused] == [422, 422]
    assert all("tick the box" in answer.text for answer in refused)
    assert 'value="Mine"' in refused[0].text
    assert team_of(site, cup, "ben") is None


@pytest.mark.parametrize("name", ["", " ", "x" * 61, "TEAM ANN"])
def test_a_team_whose_name_is_refused_is_not_made_and_the_form_says_why(
    site: Site, name: str
) -> None:
    cup = Cup.opened(site)
    cup.team("ann")

    answer = site.browser("ben").post(f"{PAGE}/teams", {"team": name} | AGREED)

    assert answer.status_code == 422
    assert 'id="team-error"' in answer.text
    assert team_of(site, cup, "ben") is None


def test_the_organiser_cannot_take_part_and_a_full_team_takes_nobody(site: Site) -> None:
    cup = Cup.opened(site, team_size=1)
    cup.team("ann")
    link = link_of(site, "ann") if "/join/" in page_of(site, "ann") else ""
    with site.database.reading() as session:
        team = teams.of_user(session, cup.id, site.user_id("ann"))
    assert team is not None

    own = site.browser("olga").post(f"{PAGE}/teams", {"team": "Mine"} | AGREED)
    full = site.browser("ben").post(f"{PAGE}/join", {"code": team.code} | AGREED)

    assert link == ""  # the page says that the team is full instead
    assert own.status_code == full.status_code == 422
    assert "You organise this competition" in own.text
    assert "is full" in full.text


def test_who_is_not_signed_in_is_led_back_to_the_link_after_signing_in(site: Site) -> None:
    Cup.opened(site).team("ann")
    link = link_of(site, "ann")

    page = site.browser().get(link).text

    assert f'href="/sign-in?next={link}"' in page
    assert f'href="/sign-up?next={link}"' in page
    assert "Join team" not in page


def test_a_link_that_the_captain_has_replaced_joins_nobody_and_names_no_team(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", name="Kelp")
    old = link_of(site, "ann")
    site.browser("ann").post(f"{TEAM}/link")

    page = site.browser("ben").get(old)
    refused = site.browser("ben").post(f"{PAGE}/join", {"code": old} | AGREED)

    assert page.status_code == refused.status_code == 404
    assert "Kelp" not in page.text
    assert link_of(site, "ann") != old
    assert team_of(site, cup, "ben") is None


def test_the_link_of_a_team_of_another_competition_joins_nobody(site: Site) -> None:
    cup = Cup.opened(site)
    Cup.opened(site, name="other-cup-v1").team("ann")
    with site.database.reading() as session:
        theirs = session.connection().exec_driver_sql("SELECT code FROM teams").scalar_one()

    answer = site.browser("ben").post(f"{PAGE}/join", {"code": theirs} | AGREED)

    assert answer.status_code == 404
    assert team_of(site, cup, "ben") is None


def test_a_captain_renames_the_team_removes_a_member_and_hands_over(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben", "eva")
    ann, ben, eva = (site.user_id(name) for name in ("ann", "ben", "eva"))

    site.browser("ann").post(TEAM, {"team": "Wrack"})
    site.browser("ann").post(f"{TEAM}/members/{ben}/remove")
    site.browser("ann").post(f"{TEAM}/members/{eva}/captain")

    team = team_of(site, cup, "eva")
    assert team is not None
    assert (team.name, team.captain_id) == ("Wrack", eva)
    assert [member.user_id for member in team.members] == [ann, eva]


@pytest.mark.parametrize(
    "change", ["", "/link", "/members/{ann}/remove", "/members/{ben}/captain", "/entries/1/choose"]
)
def test_a_member_who_is_no_captain_changes_nothing_of_the_team(site: Site, change: str) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben")
    before = team_of(site, cup, "ann")
    numbers = {name: site.user_id(name) for name in ("ann", "ben")}

    answer = site.browser("ben").post(TEAM + change.format(**numbers), {"team": "Mine"})

    assert answer.status_code == 403
    assert team_of(site, cup, "ann") == before
    assert not re.search(r">(Rename|New link|Remove|Make captain)<", page_of(site, "ben"))


@pytest.mark.parametrize("member", ["ann", "eva"])
def test_a_captain_removes_neither_themselves_nor_members_of_other_teams(
    site: Site, member: str
) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben")
    cup.team("eva")

    answer = site.browser("ann").post(f"{TEAM}/members/{site.user_id(member)}/remove")

    assert answer.status_code == 404
    assert team_of(site, cup, member) is not None


def test_who_leaves_takes_no_entry_along_and_the_next_member_is_captain(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben")
    cup.entered("ann", [40.0, 41.0, 42.0], method="Steady")

    answer = site.browser("ann").post(f"{TEAM}/leave")

    assert answer.headers["Location"] == PAGE
    assert site.browser("ann").get(TEAM).status_code == 403
    assert "Steady" in page_of(site, "ben")
    team = team_of(site, cup, "ben")
    assert team is not None
    assert team.captain_id == site.user_id("ben")


def test_a_team_sees_its_entries_and_no_other_one_does(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben")
    cup.team("eva")
    scored = cup.entered("ben", [40.0, 41.0, 42.0], method="Steady <i>")
    failed = cup.submit("ann", method="Wild")
    cup.fail(failed, FailureReason.PLATFORM_ERROR)

    own, others = page_of(site, "ann"), page_of(site, "eva")

    assert "<bdi>Steady &lt;i&gt;</bdi>" in own
    assert "41.00" in own
    assert "by <bdi>ben</bdi>" in own
    assert f'href="/runs/{scored}"' in own
    assert own.count('title="It does not count for the quota"') == 1
    assert "2 of 3 submissions left" in own
    assert "Steady" not in others
    assert "Your team has not submitted anything yet." in others


def test_a_captain_withdraws_an_entry_and_the_board_loses_it(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann")
    run_id = cup.entered("ann", [40.0, 41.0, 42.0], method="Steady")
    path = f"{TEAM}/entries/{run_id}/withdraw"

    asked = site.browser("ann").post(path, {"question": "Withdraw it?"})
    before = "Steady" in site.browser().get(PAGE).text
    site.browser("ann").post(path)

    assert "Are you sure?" in asked.text
    assert before
    assert "Steady" not in site.browser().get(PAGE).text
    assert ">withdrawn</span>" in page_of(site, "ann")


def test_the_captain_chooses_for_the_final_where_the_rules_let_teams_choose(site: Site) -> None:
    final = round_of("final", 2 * DAY_S, None, trials=6, batches=2, carry="chosen")
    qualification = round_of("qualification", -DAY_S, DAY_S, trials=3, quota=3)
    cup = Cup.opened(site, rounds=[qualification, final])
    cup.team("ann")
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])
    path = f"{TEAM}/entries/{run_id}/choose"

    site.browser("ann").post(path, {"chosen": "yes"})
    chosen = page_of(site, "ann")
    site.browser("ann").post(path, {"chosen": "no"})

    assert ">in the final</span>" in chosen
    assert "Out of the final" in chosen
    assert "Into the final" in page_of(site, "ann")


def test_nothing_is_to_choose_where_the_best_entries_go_into_the_final(site: Site) -> None:
    cup = Cup.opened(site)
    team_id = cup.team("ann")
    run_id = cup.entered("ann", [40.0, 41.0, 42.0])

    page = site.browser("ann").post(
        f"{TEAM}/entries/{run_id}/choose", {"chosen": "yes"}, follow_redirects=True
    )

    assert "The best entries go into the final by themselves." in page.text
    assert "Into the final" not in page.text
    with site.database.reading() as session:
        assert not any(each.chosen for each in entries.own(session, cup.view, team_id))

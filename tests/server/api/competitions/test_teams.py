"""Teams at the API: founded, joined, changed and left, and what of them others see."""

from typing import Any

import pytest

from tests.server.api.conftest import Site
from tests.server.judging.cup import NAME, Cup

CUP = f"/api/v1/competitions/{NAME}"


def found(site: Site, who: str = "ann", **changes: Any) -> Any:
    body = {"name": "Reef", "agree": True} | changes
    return site.call(who, "POST", f"{CUP}/teams", json=body)


def join(site: Site, who: str, code: str) -> Any:
    return site.call(who, "POST", f"{CUP}/teams/join", json={"code": code, "agree": True})


def test_a_team_is_founded_and_joined_by_its_link(hall: Site) -> None:
    Cup.opened(hall)
    made = found(hall)
    team = made.get_json()
    joined = join(hall, "ben", team["join_url"])
    again = join(hall, "ben", team["code"].lower())

    assert made.status_code == 201
    assert made.headers["Location"] == f"{CUP}/team"
    assert team["join_url"].endswith(f"/competitions/{NAME}/join/{team['code']}")
    assert (joined.status_code, again.status_code) == (200, 200)
    assert [(one["name"], one["captain"]) for one in again.get_json()["members"]] == [
        *(("ann", True), ("ben", False)),
    ]
    assert hall.call("ben", "GET", CUP).get_json()["own_team"] == "Reef"


@pytest.mark.parametrize("agree", [None, False, "true"])
def test_nobody_takes_part_without_agreeing_on_the_rules(hall: Site, agree: object) -> None:
    Cup.opened(hall)
    code = found(hall).get_json()["code"]
    given = {} if agree is None else {"agree": agree}
    answers = [
        hall.call("ben", "POST", f"{CUP}/teams", json={"name": "Wreck"} | given),
        hall.call("ben", "POST", f"{CUP}/teams/join", json={"code": code} | given),
    ]

    assert [answer.status_code for answer in answers] == [422, 422]
    assert {answer.get_json()["errors"][0]["field"] for answer in answers} == {"agree"}


def test_only_members_see_the_code_of_a_team(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.entered("ann", [1.0, 2.0, 3.0]) if cup.team("ann", "ben") else None
    code = hall.call("ben", "GET", f"{CUP}/team").get_json()["code"]
    paths = ("", "/rounds/2/board", "/rounds/2/board?format=csv", "/check", "/team", "/entries")
    told = [hall.call(who, "GET", CUP + at).text for who in ("olga", "eva", "root") for at in paths]

    assert len(code) == 11
    assert not [text for text in told if code in text]


def test_an_organiser_and_a_member_of_a_team_join_no_other(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("eva", name="Wreck")
    code = found(hall).get_json()["code"]

    organiser, member, same = join(hall, "olga", code), join(hall, "eva", code), found(hall, "ben")
    unknown = join(hall, "ben", "00000-00000")

    assert (organiser.status_code, member.status_code) == (409, 409)
    assert same.get_json()["errors"][0]["field"] == "name"
    assert unknown.get_json()["errors"][0]["field"] == "code"


def test_a_captain_renames_the_team_replaces_its_code_and_hands_it_on(hall: Site) -> None:
    Cup.opened(hall)
    first = found(hall).get_json()["code"]
    ben = join(hall, "ben", first).get_json()["members"][1]["user_id"]
    refused = hall.call("ben", "PATCH", f"{CUP}/team", json={"name": "Bens"})
    body = {"name": "Deep Reef", "new_code": True, "captain": ben}
    changed = hall.call("ann", "PATCH", f"{CUP}/team", json=body).get_json()
    stranger = {"captain": hall.user_id("eva")}

    assert refused.status_code == 403
    assert changed["name"] == "Deep Reef"
    assert changed["code"] != first
    assert [one["name"] for one in changed["members"] if one["captain"]] == ["ben"]
    assert hall.call("ann", "PATCH", f"{CUP}/team", json={"name": "Mine"}).status_code == 403
    assert hall.call("ben", "PATCH", f"{CUP}/team", json=stranger).status_code == 422
    assert join(hall, "eva", first).status_code == 422


def test_a_member_leaves_and_a_captain_removes_one(hall: Site) -> None:
    cup = Cup.opened(hall)
    cup.team("ann", "ben", "eva")
    ann, ben, eva = map(hall.user_id, ("ann", "ben", "eva"))

    def remove(who: str, user_id: int) -> int:
        path = f"{CUP}/team/members/{user_id}"
        return hall.call(who, "DELETE", path).status_code

    assert remove("ben", eva) == 403
    assert remove("tim", ben) == 403
    assert remove("ann", hall.user_id("tim")) == 404
    assert remove("ann", eva) == 204
    assert remove("ann", ann) == 204
    team = hall.call("ben", "GET", f"{CUP}/team").get_json()
    assert [(one["name"], one["captain"]) for one in team["members"]] == [("ben", True)]


def test_wrong_codes_are_counted(hall: Site) -> None:
    Cup.opened(hall)
    statuses = [join(hall, "ben", f"00000-000{at:02}").status_code for at in range(22)]

    assert set(statuses[:20]) == {422}
    assert statuses[-1] == 429

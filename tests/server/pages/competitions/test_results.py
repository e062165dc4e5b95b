"""The results of a decided competition, for people who were not there."""

import io
import json
import zipfile
from xml.etree import ElementTree

import pytest

from seamark.competitions import audit
from seamark.competitions.findings import Level
from tests.server.judging.cup import NAME, Cup
from tests.server.judging.test_finals import APART, BETTER, SAME
from tests.server.pages.conftest import Site

RESULTS = f"/competitions/{NAME}/results"


def decided(site: Site, **changes: object) -> Cup:
    """Return a decided competition of two teams, the second of which has a hostile name."""
    cup = Cup.opened(site, **changes)
    cup.team("ann", "ben", name="Reef")
    cup.team("eva", name="<b>Wreck</b> & Sons")
    cup.entered("ann", SAME, "Sliding mode")
    cup.entered("eva", SAME, "MPC", config={"kp": 0.7})
    cup.begin_final()
    cup.play_batch({"Sliding mode": BETTER, "MPC": APART})
    cup.advance()
    return cup


def test_a_spectator_without_an_account_sees_podium_board_and_replays(site: Site) -> None:
    cup = decided(site)
    page = site.browser().get(RESULTS).text

    assert page.index("Reef") < page.index("&lt;b&gt;Wreck&lt;/b&gt; &amp; Sons")
    first, second = (row.run_id for row in cup.board(3).rows)
    assert f"/api/v1/compare?runs={first},{second}" in page
    assert "<b>Wreck" not in page


def test_there_are_no_results_before_the_competition_is_decided(site: Site) -> None:
    Cup.opened(site)

    for path in (RESULTS, f"{RESULTS}/embed", f"/competitions/{NAME}/archive.zip"):
        assert site.browser().get(path).status_code == 404


def test_what_a_team_says_of_its_method_stands_with_the_results(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann", "ben", name="Reef")
    cup.entered("ann", SAME, "Sliding mode")
    member = site.browser("ben")
    member.post(
        f"/competitions/{NAME}/team/methods", {"method": "sliding mode", "text": "A <surface>."}
    )
    cup.begin_final()
    cup.play_batch({"Sliding mode": APART})
    cup.advance()

    assert "A &lt;surface&gt;." in site.browser().get(RESULTS).text


def test_a_method_of_another_team_is_not_described(site: Site) -> None:
    cup = Cup.opened(site)
    cup.team("ann")
    cup.team("eva")
    cup.entered("ann", SAME, "Sliding mode")
    other = site.browser("eva")
    other.post(f"/competitions/{NAME}/team/methods", {"method": "Sliding mode", "text": "Mine."})

    assert "has not entered this method" in other.get(f"/competitions/{NAME}/team").text


def test_the_certificate_of_a_team_names_place_team_and_members(site: Site) -> None:
    cup = decided(site)
    reef = cup.board(3).rows[0].team_id
    answer = site.browser().get(f"/competitions/{NAME}/certificates/{reef}.svg")
    texts = [element.text for element in ElementTree.fromstring(answer.data).iter()]  # noqa: S314 - ours

    assert answer.mimetype == "image/svg+xml"
    assert {"Place 1", "Reef", "ann, ben", "with the method Sliding mode"} <= set(texts)


def test_a_hostile_name_is_a_text_of_its_certificate(site: Site) -> None:
    cup = decided(site)
    wreck = cup.board(3).rows[1].team_id
    answer = site.browser().get(f"/competitions/{NAME}/certificates/{wreck}.svg")
    drawing = ElementTree.fromstring(answer.data)  # noqa: S314 - ours

    assert "<b>Wreck</b> & Sons" in [element.text for element in drawing.iter()]
    assert not [element for element in drawing.iter() if element.tag.endswith("}b")]


def test_a_team_without_a_place_has_no_certificate(site: Site) -> None:
    decided(site)

    answer = site.browser().get(f"/competitions/{NAME}/certificates/99.svg")
    assert answer.status_code == 404


def test_other_pages_may_show_the_places_in_a_frame(site: Site) -> None:
    decided(site)
    answer = site.browser().get(f"{RESULTS}/embed")

    assert "frame-ancestors 'self'" in answer.headers["Content-Security-Policy"]
    assert "Reef" in answer.text


def test_the_audit_file_of_the_page_holds(site: Site) -> None:
    decided(site).freeze_again()
    answer = site.browser().get(f"/competitions/{NAME}/audit.json")

    found = audit.verify(json.loads(answer.data))
    assert [one.sentence for one in found if one.level is Level.PROBLEM] == []


@pytest.mark.parametrize(("programs", "shown"), [("hidden", False), ("public", True)])
def test_the_archive_has_everything_and_programs_only_by_the_rules(
    site: Site, programs: str, shown: bool
) -> None:
    cup = Cup.opened(site, programs=programs)
    cup.team("ann", name="Reef")
    own = cup.submit("ann", "Mine", controller="upload", program=site.store_program())
    cup.finish(own, SAME)
    cup.begin_final()
    cup.play_batch({"Mine": APART})
    cup.advance()
    answer = site.browser().get(f"/competitions/{NAME}/archive.zip")
    names = zipfile.ZipFile(io.BytesIO(answer.data)).namelist()

    assert {"README.txt", "competition.json", "audit.json", "citation.bib"} <= set(names)
    assert "boards/round-3-final.csv" in names
    assert any("/program/" in name for name in names) is shown
    assert any(name.endswith("/run.json") for name in names)

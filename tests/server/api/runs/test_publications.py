"""Publications over the API: terms, documents, withdrawal and verification."""

import io
import zipfile
from typing import Any

import pytest
import yaml

from seamark.server.runs.publication import publications
from tests.server.api.conftest import Site

RUNS = "/api/v1/runs"
CITING = ("citation.bib", "citation.cff", "badge.svg")
DOCUMENTS = ("publication", *CITING)


def test_a_run_is_published_revealed_and_described_with_its_terms(site: Site) -> None:
    run_id = site.recorded(kind="ranked")
    terms = {"licence": "EUPL-1.2", "anonymous": True, "method": "Steady hand"}

    answer = site.call("owner", "POST", f"{RUNS}/{run_id}/publish", json=terms)
    before = site.call("guest", "GET", f"{RUNS}/{run_id}/publication").get_json()
    revealed = site.call("owner", "POST", f"{RUNS}/{run_id}/reveal")
    after = site.call("guest", "GET", f"{RUNS}/{run_id}/publication").get_json()

    assert (answer.status_code, revealed.status_code) == (200, 200)
    assert (before["author"], before["method"]) == ("Anonymous author", "Steady hand")
    assert (before["licence"], before["address"]) == ("EUPL-1.2", f"http://localhost/p/{run_id}")
    assert (after["author"], after["anonymous"], after["verifications"]) == ("ann", False, [])
    manifest = site.call("guest", "GET", f"{RUNS}/{run_id}/manifest.json").get_json()
    assert manifest["publication"]["address"] == f"http://localhost/p/{run_id}"


def test_without_the_name_of_its_method_a_program_is_refused_in_the_field(site: Site) -> None:
    run_id = site.recorded()

    answer = site.call("owner", "POST", f"{RUNS}/{run_id}/publish")

    assert answer.status_code == 422
    assert [error["field"] for error in answer.get_json()["errors"]] == ["method"]


@pytest.mark.parametrize(
    "body", [{"licence": "Beerware"}, {"program": False, "licence": "MIT"}, {"name": "x"}]
)
def test_impossible_terms_are_refused(site: Site, body: dict[str, Any]) -> None:
    run_id = site.recorded()

    answer = site.call("owner", "POST", f"{RUNS}/{run_id}/publish", json=body)

    assert answer.status_code == 422
    assert not site.show(run_id).public


def test_of_results_alone_other_users_get_the_telemetry_but_neither_program_nor_log(
    site: Site,
) -> None:
    run_id = site.publish(site.recorded(), program=False)
    paths = ("telemetry.csv", "citation.bib", "program", "log")

    statuses = [site.call("other", "GET", f"{RUNS}/{run_id}/{path}").status_code for path in paths]
    rerun = site.call("other", "POST", f"{RUNS}/{run_id}/rerun")

    assert statuses == [200, 200, 403, 403]
    assert rerun.status_code == 403


def test_a_withdrawn_publication_is_said_to_be_gone_not_unknown(
    site: Site,
) -> None:
    run_id = site.publish(site.recorded())
    with site.database.writing() as session:
        publications.withdraw(session, run_id)

    gone = [site.call("guest", "GET", f"{RUNS}/{run_id}/{name}") for name in DOCUMENTS]

    assert [answer.status_code for answer in gone] == [410] * len(DOCUMENTS)
    assert gone[0].get_json()["type"] == "/problems/withdrawn"


def test_a_badge_shows_score_and_rank_and_other_sites_may_show_and_keep_it(site: Site) -> None:
    run_id = site.publish(site.recorded(kind="ranked"))

    path = f"{RUNS}/{run_id}/badge.svg"

    answer = site.call("guest", "GET", path)
    again = site.call("guest", "GET", path, headers={"If-None-Match": answer.headers["ETag"]})

    assert "50.00" in answer.text
    assert "rank 1 of 1" in answer.text
    assert answer.headers["Cross-Origin-Resource-Policy"] == "cross-origin"
    assert "max-age=300" in answer.headers["Cache-Control"]
    assert again.status_code == 304


def test_of_a_practice_run_badge_and_citations_say_what_it_is_and_where(site: Site) -> None:
    config = {"levels": [0.0, 0.2], "level_duration_s": 60.0}
    run_id = site.publish(site.recorded(config=config))
    words = "changed scenario with 2 of 5 levels of 60 s, 1 trial"

    texts = {name: site.call("guest", "GET", f"{RUNS}/{run_id}/{name}").text for name in CITING}

    assert all(f"ractice, {words}" in text for text in texts.values())  # it may begin a sentence
    assert f"http://localhost/p/{run_id}" in texts["citation.bib"]
    assert f"http://localhost/p/{run_id}" in texts["citation.cff"]


def test_badge_and_citations_of_a_ranked_run_do_not_mention_practice_or_trials(site: Site) -> None:
    run_id = site.publish(site.recorded(kind="ranked"))

    texts = [site.call("guest", "GET", f"{RUNS}/{run_id}/{name}").text for name in CITING]

    assert not any(word in text.lower() for text in texts for word in ("practice", "trial"))


@pytest.mark.slow
def test_the_archive_of_a_public_run_is_ready_to_be_cited_and_deposited(site: Site) -> None:
    run_id = site.publish(site.recorded(), licence="MIT")

    archive = site.call("guest", "GET", f"{RUNS}/{run_id}/archive.zip").data

    with zipfile.ZipFile(io.BytesIO(archive)) as read:
        names = {name.rpartition("/")[2]: name for name in read.namelist()}
        wanted = {"CITATION.cff", "citation.bib", ".zenodo.json", "LICENSE", "README.md"}
        assert wanted <= names.keys()
        cited = yaml.safe_load(read.read(names["CITATION.cff"]))
        assert b"SPDX-License-Identifier: MIT" in read.read(names["LICENSE"])
    assert cited["authors"] == [{"name": "ann"}]


def test_an_owner_may_have_a_published_entry_verified_once_and_an_admin_again(site: Site) -> None:
    run_id = site.publish(site.recorded(kind="ranked"))
    path = f"{RUNS}/{run_id}/verify"

    statuses = [site.call(who, "POST", path).status_code for who in ("other", "owner", "owner")]
    site.finish(site.claim_next(), score=51.0)
    statuses += [site.call(who, "POST", path).status_code for who in ("owner", "admin")]
    publication = site.call("guest", "GET", f"{RUNS}/{run_id}/publication").get_json()
    board = site.call("guest", "GET", "/api/v1/leaderboards/currents-v1").get_json()
    table = site.call("guest", "GET", "/api/v1/leaderboards/currents-v1?format=csv").text

    assert statuses == [403, 202, 409, 409, 202]
    assert publication["verification_pending"]
    assert [each["outcome"] for each in publication["verifications"]] == ["agrees"]
    assert board["ranks"][0]["verification"]["digest"] == "0" * 64
    assert "agrees" in table

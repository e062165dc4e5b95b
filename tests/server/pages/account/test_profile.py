"""The page of a user and the form of one's own profile."""

import pytest

from tests.server.pages.conftest import Site

FILLED = {
    "public_name": "Ann <b>Example</b>",
    "affiliation": "University of Girona",
    "paper_url": "https://doi.org/10.1000/182",
    "code_url": "http://example.org/~ann?q=1",
}
API = "/api/v1/users/"


def test_a_profile_is_shown_with_links_that_say_whose_they_are(site: Site) -> None:
    answer = site.browser("ann").post("/profile", FILLED)
    shown = site.browser().get("/users/Ann").text

    assert (answer.status_code, answer.location) == (303, "/users/ann")
    assert "Ann &lt;b&gt;Example&lt;/b&gt;" in shown
    assert "University of Girona" in shown
    for address in (FILLED["paper_url"], FILLED["code_url"]):
        assert f'href="{address}" rel="nofollow ugc noopener"' in shown
    stored = site.browser().get(f"{API}ann").get_json()
    assert {name: stored[name] for name in FILLED} == FILLED


@pytest.mark.slow
@pytest.mark.parametrize(
    "address",
    [
        "javascript:alert(1)",
        "data:text/html,x",
        "//example.org/x",
        "https://",
        "https://name:secret@example.org/",
        "https://example.org/ x",
        "https://exam\u0440le.org/",
        "https://[",
        "https://example.org/" + "x" * 300,
    ],
)
def test_only_web_addresses_are_links(site: Site, address: str) -> None:
    answer = site.browser("ann").post("/profile", FILLED | {"code_url": address})
    by_api = site.browser("ann").get("/profile")

    assert answer.status_code == 422
    assert 'id="profile-code_url-error"' in answer.text
    assert 'value="University of Girona"' in answer.text
    assert "University of Girona" not in by_api.text


def test_names_are_limited_and_keep_their_direction(site: Site) -> None:
    for name, value in (("public_name", "a" * 81), ("affiliation", "a\u202eb")):
        answer = site.browser("ann").post("/profile", {name: value})

        assert answer.status_code == 422, name
        assert f'id="profile-{name}-error"' in answer.text


def test_who_has_shown_nothing_has_no_page(site: Site) -> None:
    site.succeeded("ann", kind="ranked")  # private

    for path in ("/users/ann", f"{API}ann", "/users/nobody", "/users/seamark-pi", "/users/a%0Ab"):
        assert site.browser("ben").get(path).status_code == 404, path
    assert site.browser("ann").get("/users/ann").status_code == 200

    site.published("ann", title="First try")
    assert "First try" in site.browser("ben").get("/users/ann").text


@pytest.mark.slow
def test_a_page_has_the_ranks_with_their_history_and_published_runs_alone(site: Site) -> None:
    site.published("ben", kind="ranked")
    first = site.published("ann", kind="ranked", title="Public plan")
    claim = site.running("ann", kind="ranked", title="Secret plan")
    assert site.finish(claim, score=70.0)

    before = site.browser().get("/users/ann").text
    assert "Public plan" in before
    assert "Secret plan" not in before
    assert "Ranked 2nd of 2" in before

    site.publish(claim.run_id)
    found = site.browser().get(f"{API}ann").get_json()
    shown = site.browser().get("/users/ann").text

    assert found["runs"] == [claim.run_id, first]
    (rank,) = found["ranks"]
    assert (rank["benchmark"], rank["rank"], rank["people"]) == ("currents-v1", 1, 2)
    assert [point["rank"] for point in rank["history"]] == [2, 1]
    assert "Ranked 1st of 2" in shown
    assert "Rank over time: first 2, best 1, last 1" in shown

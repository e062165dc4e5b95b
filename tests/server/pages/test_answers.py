"""What all answers have in common: headers, errors, ranks, numbers."""

import pytest

from seamark.server.accounts import accounts
from seamark.server.accounts.permissions import SUBMIT
from seamark.server.runs.data.run_size import size
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.web.template_filters import duration, number
from tests.server.pages.conftest import Site


@pytest.mark.parametrize("path", ["/", "/nope", "/static/css/base.css", "/api/v1/benchmarks"])
def test_every_response_has_the_security_headers(site: Site, path: str) -> None:
    with site.browser().get(path) as answer:
        headers = answer.headers

    policy = headers["Content-Security-Policy"]
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Referrer-Policy"]


@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/submit/currents-v1",
        "/docs/controller",
        "/status",
        "/leaderboards/currents-v1",
        "/benchmarks/currents-v1",
        "/docs/physics",
    ],
)
def test_no_page_has_inline_code_or_loads_from_elsewhere(site: Site, path: str) -> None:
    page = site.browser("ann").get(path).text

    assert [
        word for word in (" style=", " onclick=", "<style", "//cdn", 'src="http') if word in page
    ] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "/nope",
        "/runs/999",
        "/docs/nope",
        "/submit/nope",
        "/leaderboards/nope",
        "/benchmarks/nope",
        "/docs/physics/nope.urdf",
        "/leaderboards/currents-v1?after=x",
        "/leaderboards/currents-v1?after=nan_0x1p0_1",
        f"/runs/{10**40}",
    ],
)
def test_what_does_not_exist_gives_a_404_page(site: Site, path: str) -> None:
    answer = site.browser().get(path)

    assert answer.status_code == 404
    assert "Page not found" in answer.text


@pytest.mark.parametrize("path", ["/runs/?after={}", "/submit/currents-v1?from={}"])
def test_a_number_that_no_row_can_have_is_ignored(site: Site, path: str) -> None:
    answer = site.browser("ann").get(path.format(10**40))

    assert answer.status_code == 200


def test_the_api_reports_errors_as_problem_documents(site: Site) -> None:
    answer = site.browser().get("/api/v1/runs/999")

    assert (answer.status_code, answer.mimetype) == (404, "application/problem+json")


def test_a_published_ranked_run_is_on_the_leaderboard_and_a_private_one_is_not(
    site: Site,
) -> None:
    site.published("ann", kind="ranked")
    site.succeeded("ben", kind="ranked")

    page = site.browser().get("/leaderboards/currents-v1").text

    assert (">ann</a>" in page, ">ben</a>" in page) == (True, False)


def test_the_leaderboard_says_which_ranks_are_possible(site: Site) -> None:
    for name in ("ann", "ben"):
        site.published(name, kind="ranked")

    page = site.browser().get("/leaderboards/currents-v1").text

    assert page.count("(1–2)</small>") == 2


def test_the_next_page_of_the_leaderboard_starts_after_the_cursor(site: Site) -> None:
    site.published("ann", kind="ranked")
    site.published("ben", kind="ranked")
    with site.database.reading() as session:
        first = leaderboard.page(session, "currents-v1", limit=1)[0]

    after = {"after": first.cursor.text()}
    page = site.browser().get("/leaderboards/currents-v1", query_string=after).text

    assert (f">{first.user}</a>" in page, ">Top</a>" in page) == (False, True)


def test_my_runs_are_filtered_by_state(site: Site) -> None:
    site.succeeded("ann", title="done one")
    site.queue("ann", title="waiting one")

    page = site.browser("ann").get("/runs/?state=queued").text

    assert ("waiting one" in page, "done one" in page) == (True, False)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.01234, "0.0123"), (1234.5, "1\u202f234"), (0, "0"), (-2.5, "−2.50"), (None, "–"),
     (float("nan"), "–"), (True, "yes"), (1e-7, "1e−07"), ([0, 0.1], "0, 0.100")],
)  # fmt: skip
def test_numbers_are_formatted_for_people(value: object, text: str) -> None:
    assert number(value) == text


def test_sizes_and_durations_are_formatted_for_people() -> None:
    assert (size(2 * 2**20), size(300), duration(75), duration(3720)) == (
        "2 MiB",
        "300 bytes",
        "1 min 15 s",
        "1 h 2 min",
    )


def test_an_admin_can_filter_runs_by_user_and_download_them(site: Site) -> None:
    site.succeeded("ann", title="=alpha")
    site.succeeded("ben", title="beta")
    admin = site.browser("root")

    page = admin.get("/runs/?of=all&user=BEN").text
    table = admin.get("/runs/runs.csv?of=all").text
    others = site.browser("ben").get("/runs/runs.csv?of=all").text

    assert ("beta" in page, "alpha" in page) == (True, False)
    assert [line.split(",")[1] for line in table.splitlines()] == ["user", "ben", "ann"]
    assert "'=alpha" in table
    assert ("beta" in others, "alpha" in others) == (True, False)


def test_a_ranked_run_is_compared_with_the_previous_one_by_its_owner_alone(site: Site) -> None:
    for score in (0.4, 0.3):
        solution = {"benchmark": "currents-v2", "config": {"kp": 1.0 + score}}
        claim = site.running("ann", kind="ranked", **solution)
        common = {"part": "reference", "level_held": 0.2, "overall": {}, "levels": []}
        trials = [common | {"trial": at, "score": score + 0.1 * at} for at in range(4)]
        assert site.finish(claim, metrics={"score": score, "trials": trials})
    site.publish(claim.run_id)

    own = site.browser("ann").get(f"/runs/{claim.run_id}").text
    public = site.browser().get(f"/runs/{claim.run_id}").text
    with site.database.writing() as session:
        token = accounts.new_token(session, site.user_id("ann"), "submits", [SUBMIT], days=1.0)
    bearer = {"Authorization": f"Bearer {token}"}
    without_scope = site.browser().get(f"/runs/{claim.run_id}", headers=bearer).text

    assert "−0.100" in own
    assert "On the same reference trials" in own
    assert "On the same reference trials" not in public
    assert "On the same reference trials" not in without_scope

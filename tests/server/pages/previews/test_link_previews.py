"""What other sites show of a link to a run, a comparison or a leaderboard."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.leaderboard import leaderboard
from seamark.server.runs.publication import publications
from seamark.server.runs.showing import preview_pictures
from seamark.server.settings import Settings
from seamark.sim import registry
from seamark.sim.recording.telemetry import INDEX, WIDTH
from tests.server.pages.conftest import Site

HOST = "https://seamark.example"
_META = re.compile(r'<meta (?:property|name)="((?:og|twitter):[^"]+)" content="([^"]*)">')


@pytest.fixture
def settings(settings: Settings) -> Settings:
    return settings.model_copy(update={"url": HOST})


def _meta(page: str) -> dict[str, str]:
    return dict(_META.findall(page))


def _recorded(site: Site, who: str = "ann", **changes: object) -> int:
    run_id = site.succeeded(who, seed=7, **changes)
    rows = np.zeros((100, WIDTH))
    rows[:, INDEX["t"]] = 0.05 * np.arange(100)
    rows[:, INDEX["z"]] = 1.65
    rows[:, INDEX["distance_px"]] = np.arange(100.0)
    rows[50, INDEX["distance_px"]] = np.nan
    RunFiles(site.settings.data, run_id, 1).append_rows(rows)
    return run_id


def _is_a_picture(jpeg: bytes) -> bool:
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    return image is not None and image.shape == (630, 1200, 3) and float(image.std()) > 5.0


def test_a_public_run_has_a_preview_with_a_picture_of_the_run(site: Site) -> None:
    run_id = site.publish(_recorded(site, title="Calm water"))
    stranger = site.browser()

    meta = _meta(stranger.get(f"/runs/{run_id}").text)
    picture = stranger.get(f"/runs/{run_id}/preview.jpg")
    again = stranger.get(
        f"/runs/{run_id}/preview.jpg", headers={"If-None-Match": picture.headers["ETag"]}
    )

    assert meta["og:title"] == f"Run {run_id}: Calm water"
    assert "50.00 of 100 (45.00 to 55.00)" in meta["og:description"]
    assert meta["og:url"] == f"{HOST}/runs/{run_id}"
    assert meta["og:image"] == f"{HOST}/runs/{run_id}/preview.jpg"
    assert meta["twitter:card"] == "summary_large_image"
    assert _is_a_picture(picture.data)
    assert picture.headers["Cross-Origin-Resource-Policy"] == "cross-origin"
    assert "public" not in picture.headers["Cache-Control"]
    assert again.status_code == 304


def test_a_leaderboard_and_a_comparison_have_a_preview_with_a_picture(site: Site) -> None:
    ids = [site.publish(_recorded(site)) for _ in range(2)]
    site.published("eva", kind="ranked")
    pages = ("/leaderboards/currents-v1", f"/compare?runs={ids[0]},{ids[1]}")

    for path in pages:
        meta = _meta(site.browser().get(path).text)
        picture = site.browser().get(meta["og:image"].removeprefix(HOST))
        assert meta["og:url"] == f"{HOST}{path}"
        assert _is_a_picture(picture.data)
    assert "eva leads with 50.00" in _meta(site.browser().get(pages[0]).text)["og:description"]


@pytest.mark.slow
@pytest.mark.parametrize("path", ["/", "/benchmarks/currents-v2"])
def test_home_and_benchmarks_have_a_preview_with_a_picture(site: Site, path: str) -> None:
    stranger = site.browser()

    meta = _meta(stranger.get(path).text)

    picture = stranger.get(meta["og:image"].removeprefix(HOST))
    assert meta["og:url"] == f"{HOST}{path}"
    assert meta["og:title"]
    assert "?" in meta["og:description"]  # the question that it answers
    assert meta["og:image"].startswith(HOST)
    assert picture.content_type == "image/jpeg"
    assert _is_a_picture(picture.data)


def test_nothing_of_a_private_run_is_shown_to_others(site: Site) -> None:
    private, public = _recorded(site, title="secret plan"), site.publish(_recorded(site, "ben"))
    stranger = site.browser("ben")
    paths = (f"/runs/{private}", f"/compare?runs={public},{private}")
    pictures = (f"/runs/{private}/preview.jpg", f"/compare/preview.jpg?runs={public},{private}")

    answers = [stranger.get(path) for path in (*paths, *pictures)]

    assert [answer.status_code for answer in answers] == [404] * 4
    assert not any("secret" in answer.text or _meta(answer.text) for answer in answers)
    assert site.browser("ann").get(pictures[0]).status_code == 200


def test_a_picture_is_gone_when_the_run_is_withdrawn(site: Site) -> None:
    run_id = site.publish(_recorded(site))
    path = f"/runs/{run_id}/preview.jpg"
    assert site.browser().get(path).status_code == 200

    with site.database.writing() as session:
        assert publications.withdraw(session, run_id)

    assert site.browser().get(path).status_code == 404


def test_the_host_that_a_client_sends_is_not_used(site: Site) -> None:
    run_id = site.publish(_recorded(site))

    page = site.browser().get(f"/runs/{run_id}", headers={"Host": "evil.example"}).text

    assert "evil.example" not in page


def test_without_an_address_in_the_settings_there_is_no_picture(site: Site) -> None:
    run_id = site.publish(_recorded(site))
    services = site.app.extensions["seamark"]
    without = services.settings.model_copy(update={"url": ""})
    site.app.extensions["seamark"] = replace(services, settings=without)

    meta = _meta(site.browser().get(f"/runs/{run_id}").text)

    assert meta["og:title"] == f"Run {run_id}: PI"
    assert (meta.get("og:image"), meta.get("og:url"), meta["twitter:card"]) == (
        None,
        None,
        "summary",
    )


def test_a_title_is_text_in_a_preview(site: Site) -> None:
    run_id = site.publish(_recorded(site, title='"><script>alert(1)</script>' + "W" * 80))

    page = site.browser().get(f"/runs/{run_id}")
    picture = site.browser().get(f"/runs/{run_id}/preview.jpg")

    assert "<script>alert" not in page.text
    assert _is_a_picture(picture.data)


def test_a_run_without_telemetry_and_score_has_a_picture(site: Site) -> None:
    run_id = site.failed({"title": "It failed"})

    assert _is_a_picture(site.browser("ann").get(f"/runs/{run_id}/preview.jpg").data)


def test_the_chart_of_a_detector_is_its_precision_over_the_depth(site: Site) -> None:
    pictures = []
    for precisions in ((90.0, 80.0, 10.0), (90.0, 20.0, 10.0)):
        claim = site.running("ann", benchmark="patterns-v1", controller="built-in")
        levels = [{"level": at, "ap_percent": value} for at, value in enumerate(precisions)]
        assert site.finish(claim, metrics={"score": 50.0, "levels": levels, "trials": []})
        encoded = site.browser("ann").get(f"/runs/{claim.run_id}/preview.jpg").data
        picture = np.asarray(cv2.imdecode(np.frombuffer(encoded, np.uint8), cv2.IMREAD_COLOR))
        pictures.append(picture[330:582, 652:1152].astype(int))  # of the chart

    assert np.abs(pictures[0] - pictures[1]).max() > 50


@pytest.mark.slow
def test_only_the_last_pictures_are_kept(site: Site) -> None:
    site.published("eva", kind="ranked")
    with site.database.reading() as session:
        (rank,) = leaderboard.page(session, "currents-v1")
    benchmark = registry.benchmark("currents-v1")

    for number in range(preview_pictures.KEPT + 5):
        preview_pictures.of_leaderboard(benchmark, [replace(rank, run_id=number)])

    assert len(preview_pictures._kept) == preview_pictures.KEPT

"""Runs in the formats of other programs: what is in the files, and what a download costs."""

import io
import json
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy  # its parts are loaded when they are used
from mcap.reader import make_reader
from werkzeug.test import TestResponse

from seamark.formats.registry import FORMATS
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.downloads.conversions import SLOTS, ConversionFailed, Conversions
from tests.cast import PROGRAM
from tests.part_programs import BENCHMARK, DETECTOR, TRACKER
from tests.server.api.conftest import Site
from tests.services import forked_commands


def fetch(site: Site, run_id: int, kind: str, role: str = "owner", **options: str) -> TestResponse:
    path = f"/api/v1/runs/{run_id}/{FORMATS[kind].file}"
    answer = site.call(role, "GET", path, headers=options)
    answer.get_data()
    return answer


def convert_with(site: Site, conversions: Conversions) -> None:
    """Let the application convert runs in this way."""
    site.app.extensions["seamark"] = replace(site.services, conversions=conversions)


@pytest.mark.slow
def test_each_format_has_the_rows_of_the_run(site: Site) -> None:
    run_id = site.recorded()
    rows = RunFiles(site.settings.data, run_id, 1).rows()

    parquet = pd.read_parquet(io.BytesIO(fetch(site, run_id, "parquet").data))
    npz = np.load(io.BytesIO(fetch(site, run_id, "npz").data))["telemetry"]
    found = scipy.io.loadmat(io.BytesIO(fetch(site, run_id, "mat").data), squeeze_me=True)

    assert parquet.to_numpy().tobytes() == rows.tobytes()
    assert npz.tobytes() == rows.tobytes()
    assert found["distance"].tobytes() == rows[:, list(npz.dtype.names).index("distance")].tobytes()


@pytest.mark.slow
def test_mcap_has_the_rows_and_an_image_per_second(site: Site) -> None:
    content = fetch(site, site.recorded(), "mcap").data

    summary = make_reader(io.BytesIO(content)).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    topics = {number: channel.topic for number, channel in summary.channels.items()}
    counts = summary.statistics.channel_message_counts
    found = {topics[number]: count for number, count in counts.items()}
    assert (found["/telemetry"], found["/camera/image/compressed"]) == (40, 2)


@pytest.mark.slow
def test_a_live_run_can_be_downloaded_in_each_format(site: Site) -> None:
    run_id = site.running().run_id
    site.record(run_id, rows=30)

    answer = fetch(site, run_id, "parquet")
    archive = zipfile.ZipFile(io.BytesIO(fetch(site, run_id, "archive").data))

    assert len(pd.read_parquet(io.BytesIO(answer.data))) == 30
    assert "seamark-run/manifest.json" not in archive.namelist()


@pytest.mark.slow
def test_the_archive_has_everything_to_compute_the_run_again(site: Site) -> None:
    run_id = site.recorded()
    answer = fetch(site, run_id, "archive")
    archive = zipfile.ZipFile(io.BytesIO(answer.data))
    files = {name.removeprefix("seamark-run/"): archive.read(name) for name in archive.namelist()}

    assert files["program/mine.py"] == PROGRAM
    assert json.loads(files["manifest.json"])["seed"] == 7
    assert json.loads(files["metrics.json"])["score"] == 50.0
    assert json.loads(files["config.json"]) == site.show(run_id).config
    csv = site.call("owner", "GET", f"/api/v1/runs/{run_id}/telemetry.csv").data
    assert files["telemetry.csv"] == csv
    assert f"seamark-run-{run_id}-archive.zip" in answer.headers["Content-Disposition"]


@pytest.mark.slow
@pytest.mark.parametrize("main", [True, False])
def test_the_archive_has_the_programs_in_further_roles(site: Site, main: bool) -> None:
    parts = {
        "detector": site.store_program(DETECTOR, "find.py", "detector"),
        "tracker": site.store_program(TRACKER, "follow.py", "tracker"),
    }
    built_in = {} if main else {"controller": "chain", "program": None}
    run_id = site.recorded(benchmark=BENCHMARK, parts=parts, **built_in)

    archive = zipfile.ZipFile(io.BytesIO(fetch(site, run_id, "archive").data))

    programs = {
        name.removeprefix("seamark-run/"): archive.read(name) for name in archive.namelist()
    }
    assert programs["parts/detector/find.py"] == DETECTOR
    assert programs["parts/tracker/follow.py"] == TRACKER
    assert programs.get("program/mine.py") == (PROGRAM if main else None)


def test_a_program_that_is_private_is_not_in_the_archive_of_others(site: Site) -> None:
    run_id = site.recorded()

    assert fetch(site, run_id, "archive", role="other").status_code == 404
    assert fetch(site, run_id, "archive", role="guest").status_code == 404


@pytest.mark.slow
def test_hidden_seeds_are_not_in_the_archive(site: Site) -> None:
    run_id = site.publish(site.recorded(kind="ranked"))
    archive = zipfile.ZipFile(io.BytesIO(fetch(site, run_id, "archive", role="other").data))

    manifest = json.loads(archive.read("seamark-run/manifest.json"))
    assert manifest["seed"] is None
    assert manifest["trials"] == [{"seed": None}]


@pytest.mark.slow
def test_who_has_the_file_already_is_not_sent_it_again(site: Site) -> None:
    run_id = site.recorded()
    with forked_commands.started_anew():
        first = fetch(site, run_id, "npz")
    convert_with(site, Conversions(command=("false",)))

    again = fetch(site, run_id, "npz", **{"If-None-Match": first.headers["ETag"]})

    assert "telemetry" in np.load(io.BytesIO(first.data))
    assert (again.status_code, again.data) == (304, b"")


def test_one_client_has_one_file_written_at_a_time(site: Site) -> None:
    run_id = site.publish(site.recorded())
    convert_with(site, Conversions(wait_s=0.05, command=("true",)))
    held = site.services.conversions.start(b"", owner=f"user:{site.user_id('ann')}")

    refused = fetch(site, run_id, "npz")
    of_another = fetch(site, run_id, "npz", role="other")
    held.close()
    after = fetch(site, run_id, "npz")

    assert (refused.status_code, refused.headers["Retry-After"]) == (429, "1")
    assert "One of your downloads had your slot" in refused.get_json()["detail"]
    assert (of_another.status_code, after.status_code) == (200, 200)


def test_a_client_that_leaves_frees_the_place_and_ends_the_process(site: Site) -> None:
    path = f"/api/v1/runs/{site.recorded()}/telemetry.npz"
    endless = ("sh", "-c", "echo $$; exec yes")
    convert_with(site, Conversions(wait_s=0.05, command=endless))

    for _ in range(2):
        answer = site.client().get(path, headers=site.headers["owner"], buffered=False)
        number, _, _ = bytes(next(answer.iter_encoded())).partition(b"\n")
        answer.close()
        assert not Path(f"/proc/{int(number)}").exists()


def test_a_client_that_takes_nothing_keeps_no_place_once_the_process_has_ended() -> None:
    conversions = Conversions(wait_s=5.0, command=("head", "-c", "100000", "/dev/zero"))
    stalled = []

    for number in range(2 * SLOTS):
        conversion = conversions.start(b"", owner=f"user:{number}")
        pieces = iter(conversion)
        assert next(pieces)  # and nothing more
        stalled.append((conversion, pieces))

    assert [sum(map(len, pieces)) > 0 for _, pieces in stalled] == [True] * 2 * SLOTS


def test_a_process_that_fails_breaks_the_download_instead_of_ending_it(site: Site) -> None:
    run_id = site.recorded()
    failing = ("sh", "-c", "echo part; echo reason >&2; exit 3")
    convert_with(site, Conversions(wait_s=0.05, command=failing))

    with pytest.raises(ConversionFailed, match=r"status 3: reason"):
        fetch(site, run_id, "npz")
    with pytest.raises(ConversionFailed):  # not ConversionsBusy: the place is free again
        fetch(site, run_id, "npz")


def test_a_mat_file_of_too_many_rows_is_refused_before_it_is_begun(
    site: Site, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(FORMATS, "mat", replace(FORMATS["mat"], rows_max=39))
    answer = fetch(site, site.recorded(), "mat")

    assert answer.status_code == 409
    assert "parquetread" in answer.get_json()["detail"]

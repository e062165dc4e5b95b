"""`seamark replay`: a log becomes a result that the other commands read."""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from mcap.reader import make_reader

from seamark.cli.main import cli
from seamark.formats.registry import FORMATS
from seamark.sim.registry import DEFAULT_BENCHMARK
from tests import telemetry_csv

pytestmark = pytest.mark.slow

OF_V1 = ("--benchmark", "currents-v1")  # that of the results
SETTINGS = (*OF_V1, "--set", "levels=0,0.3", "--set", "settle_s=1")


def seamark(*arguments: str | Path) -> Result:
    return CliRunner().invoke(cli, list(map(str, arguments)), prog_name="seamark")


@pytest.fixture(scope="module")
def replayed(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("replay") / "mission"
    answer = seamark("replay", results / "pi" / "telemetry.csv", *SETTINGS, "--out", out)
    assert answer.exit_code == 0, answer.output
    return out


def test_three_trials_have_the_digest_and_the_metrics_of_their_run(
    results: Path, replayed: Path
) -> None:
    names = ("manifest.json", "metrics.json")
    manifest, metrics = (json.loads((replayed / name).read_text()) for name in names)
    old_manifest, old = (json.loads((results / "pi" / name).read_text()) for name in names)

    assert manifest["digest"] == old_manifest["digest"]
    assert manifest["kind"] == "measured log, not simulated"
    assert len(manifest["log"]["sha256"]) == 64
    assert [trial["score"] for trial in metrics["trials"]] == [
        trial["score"] for trial in old["trials"]
    ]
    assert metrics["levels"] == old["levels"]
    assert metrics["rankable"] is False


def test_plots_and_comparisons_read_it_beside_a_run(results: Path, replayed: Path) -> None:
    plotted = seamark("plot", replayed, results / "p", "--only", "error", "--json")
    compared = seamark("compare", replayed, results / "p", "--json")

    assert len(json.loads(plotted.output)["charts"][0]["lines"]) == 2
    document = json.loads(compared.output)
    assert [run["label"] for run in document["runs"]] == ["mission", "p"]
    kinds = next(row for row in document["settings"] if row["name"] == "kind")
    assert kinds["values"] == ["log", "practice"]


def test_what_was_not_measured_is_named(replayed: Path, tmp_path: Path) -> None:
    lines = [
        line
        for line in (replayed / "telemetry.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    poses = [line.split(",")[2:9] for line in lines if line[0] == "t" or line.startswith("0,0,")]
    (tmp_path / "poses.csv").write_text("\n".join(map(",".join, poses)) + "\n")

    answer = seamark("replay", tmp_path / "poses.csv", *OF_V1, "--set", "settle_s=0", "--json")

    metrics = json.loads(answer.output)["metrics"]
    assert metrics["not_measured"]["lost_percent"] == ["tracker_error", "tracker_ok"]
    assert metrics["levels"][0]["rmse_m"] is not None
    assert metrics["levels"][0]["points"] is metrics["score"] is None


def test_a_log_is_measured_by_the_default_benchmark_unless_another_is_named(tmp_path: Path) -> None:
    lines = [f"{0.05 * at:.2f},0,0,3,0,0,0" for at in range(40)]
    (tmp_path / "poses.csv").write_text("\n".join(["t,x,y,z,roll,pitch,yaw", *lines]) + "\n")

    answers = [
        seamark("replay", tmp_path / "poses.csv", *named, "--set", "settle_s=0", "--json")
        for named in ((), OF_V1)
    ]

    assert [json.loads(answer.output)["benchmark"] for answer in answers] == [
        DEFAULT_BENCHMARK,
        "currents-v1",
    ]


def test_a_log_that_cannot_be_measured_is_wrong_usage(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,x\n0,1\n0.05,nan\n")

    answer = seamark("replay", tmp_path / "log.csv")
    unknown = seamark("replay", tmp_path / "log.csv", "--benchmark", "visibility-v1")

    assert answer.exit_code == unknown.exit_code == 2
    assert "log.csv: Line 3: x is missing or nan." in answer.output
    assert "measured by currents-v3 or currents-v2 or currents-v1" in unknown.output


@pytest.mark.parametrize("kind", list(FORMATS))
def test_the_result_of_a_log_is_exported_in_each_format(
    replayed: Path, tmp_path: Path, kind: str
) -> None:
    written = seamark("export", replayed, "--format", kind, "-o", tmp_path / "mission")

    assert written.exit_code == 0, written.output
    assert (tmp_path / "mission").stat().st_size > 10_000


def test_an_exported_log_has_its_values_and_images_where_it_has_a_pose(
    replayed: Path, tmp_path: Path
) -> None:
    corners = ["t", *(f"corner_{number}" for number in range(8))]
    lines = [",".join(map(str, [0.05 * at, *range(8)])) for at in range(40)]
    (tmp_path / "corners.csv").write_text("\n".join([",".join(corners), *lines]))
    options = ("--set", "settle_s=0", "--out", tmp_path / "corners")
    assert seamark("replay", tmp_path / "corners.csv", *options).exit_code == 0

    topics = {}
    for name, folder in (("pose", replayed), ("corners", tmp_path / "corners")):
        file = tmp_path / f"{name}.mcap"
        assert seamark("export", folder, "--format", "mcap", "-o", file).exit_code == 0
        with file.open("rb") as stream:
            summary = make_reader(stream).get_summary()
        assert summary is not None
        topics[name] = {channel.topic for channel in summary.channels.values()}
    seamark("export", replayed, "--format", "npz", "-o", tmp_path / "mission.npz")

    names, rows = telemetry_csv.read((replayed / "telemetry.csv").read_text())
    exported = np.load(tmp_path / "mission.npz")["telemetry"]
    assert np.array([exported[name] for name in names]).T.tobytes() == rows.tobytes()
    assert "/camera/image/compressed" in topics["pose"]
    assert "/camera/image/compressed" not in topics["corners"]


def test_the_archive_of_a_log_says_that_it_cannot_be_computed_again(
    replayed: Path, tmp_path: Path
) -> None:
    file = tmp_path / "mission.zip"
    assert seamark("export", replayed, "--format", "archive", "-o", file).exit_code == 0

    refused = seamark("rerun", file)

    assert refused.exit_code == 2
    assert "measured, not simulated, and cannot be computed again" in refused.output
    readme = zipfile.ZipFile(file).read("seamark-run/README.md").decode()
    assert "cannot be computed again" in readme
    assert "seamark rerun" not in readme


def test_what_was_guessed_is_printed_as_a_mapping_that_says_the_same(
    replayed: Path, tmp_path: Path
) -> None:
    lines = (replayed / "telemetry.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if line.startswith("0,0,")]
    poses = [";".join(row[2:9]).replace(".", ",") for row in rows]
    names = "Time;Northing;Easting;Depth;roll;pitch;psi"
    log, mapping = tmp_path / "poses.csv", tmp_path / "mapping.toml"
    log.write_text("\n".join([names, *poses]) + "\n")

    guessed = seamark("replay", log, "--set", "settle_s=0")
    block = guessed.output.partition("--mapping FILE:\n")[2].partition("measured")[0]
    mapping.write_text(block)
    told = seamark("replay", log, "--set", "settle_s=0", "--mapping", mapping)

    assert '    z = "Depth"\n' in block
    assert "--mapping FILE" not in told.output
    assert told.output.rpartition("digest")[2] == guessed.output.rpartition("digest")[2]

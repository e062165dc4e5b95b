"""`seamark replay`: a log becomes a result that the other commands read."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli

SETTINGS = ("--set", "levels=0,0.3", "--set", "settle_s=1")


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

    answer = seamark("replay", tmp_path / "poses.csv", "--set", "settle_s=0", "--json")

    metrics = json.loads(answer.output)["metrics"]
    assert metrics["not_measured"]["lost_percent"] == ["tracker_error", "tracker_ok"]
    assert metrics["levels"][0]["rmse_m"] is not None
    assert metrics["levels"][0]["points"] is metrics["score"] is None


def test_a_log_that_cannot_be_measured_is_wrong_usage(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("t,x\n0,1\n0.05,nan\n")

    answer = seamark("replay", tmp_path / "log.csv")
    unknown = seamark("replay", tmp_path / "log.csv", "--benchmark", "visibility-v1")

    assert answer.exit_code == unknown.exit_code == 2
    assert "log.csv: Line 3: x is missing or nan." in answer.output
    assert "measured by currents-v2 or currents-v1" in unknown.output

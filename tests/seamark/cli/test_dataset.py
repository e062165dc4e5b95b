"""`seamark dataset`: the archive it writes and the mistakes it refuses."""

import json
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli

SHORT = ("--set", "levels=0.1", "--set", "level_duration_s=3", "--set", "settle_s=1")


def _dataset(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["dataset", "currents-v1", *SHORT, *arguments])


def test_the_configuration_in_the_archive_reproduces_its_bytes(
    tmp_path: Path,
) -> None:
    first, second = tmp_path / "first.zip", tmp_path / "second.zip"
    written = _dataset("--seed", "5", "--every", "10", "--out", str(first), "--json")
    assert written.exit_code == 0
    assert json.loads(written.stdout)["pictures"] == 6

    with zipfile.ZipFile(first) as file:
        settings = file.extract("seamark-dataset/configuration.json", tmp_path)
    options = ("--config", settings, "--seed", "5", "--every", "10", "--out", str(second))
    again = CliRunner().invoke(cli, ["dataset", "currents-v1", *options])

    assert again.exit_code == 0
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--from", "50"), "there are no images"),
        (("--solution", "magic"), "There is no built-in solution magic"),
        (("--out", "/proc/nothing.zip"), "cannot be written"),
    ],
)
def test_wrong_usage_ends_with_a_message_and_leaves_no_file(
    tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    out = tmp_path / "dataset.zip"

    refused = _dataset("--out", str(out), *arguments)

    assert refused.exit_code == 2
    assert says in refused.output
    assert list(tmp_path.iterdir()) == []


def test_a_benchmark_of_routes_has_no_data_set(tmp_path: Path) -> None:
    done = CliRunner().invoke(cli, ["dataset", "track-v1", "--out", str(tmp_path / "a.zip")])

    assert done.exit_code == 2
    assert "track-v1 has no data set" in done.stderr
    assert not [*tmp_path.iterdir()]


def test_a_solution_that_knows_the_vehicle_is_told_that_of_the_trial(tmp_path: Path) -> None:
    out = str(tmp_path / "a.zip")

    done = CliRunner().invoke(
        cli, ["dataset", "currents-v3", *SHORT, "--solution", "lqr", "--every", "30", "--out", out]
    )

    assert done.exit_code == 0, done.output

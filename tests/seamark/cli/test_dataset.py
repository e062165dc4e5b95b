"""`seamark dataset` as a person uses it."""

import json
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli

SHORT = ("--set", "levels=0.1", "--set", "level_duration_s=3", "--set", "settle_s=1")


def _dataset(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["dataset", "currents-v1", *SHORT, *arguments])


def test_the_archive_says_how_to_make_it_again_and_that_gives_the_same_bytes(
    tmp_path: Path,
) -> None:
    first, second = tmp_path / "first.zip", tmp_path / "second.zip"
    made = _dataset("--seed", "5", "--every", "10", "--out", str(first), "--json")
    assert made.exit_code == 0
    assert json.loads(made.stdout)["pictures"] == 6

    with zipfile.ZipFile(first) as file:
        settings = file.extract("seamark-dataset/configuration.json", tmp_path)
    order = ("--config", settings, "--seed", "5", "--every", "10", "--out", str(second))
    again = CliRunner().invoke(cli, ["dataset", "currents-v1", *order])

    assert again.exit_code == 0
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--from", "50"), "no picture is left"),
        (("--solution", "magic"), "There is no solution magic built in"),
        (("--out", "/proc/nothing.zip"), "cannot be written"),
    ],
)
def test_a_mistake_is_a_sentence_and_leaves_no_file(
    tmp_path: Path, arguments: tuple[str, ...], says: str
) -> None:
    out = tmp_path / "dataset.zip"

    refused = _dataset("--out", str(out), *arguments)

    assert refused.exit_code == 2
    assert says in refused.output
    assert list(tmp_path.iterdir()) == []

"""Short demonstrations in each layout."""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli

SEEN = ("--set", "levels=0,0.1", "--set", "level_duration_s=2", "--set", "images=both")


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["demonstrations", *arguments])


def write(out: Path, layout: str, *, jobs: int = 1) -> Path:
    """Write three short demonstrations of valve-v1 with images."""
    options = ("--episodes", "3", "--format", layout, "--out", str(out), "--jobs", str(jobs))
    ended = run("valve-v1", *options, *SEEN)
    assert ended.exit_code == 0, ended.output
    return out


@pytest.fixture
def demonstrations() -> Callable[..., Result]:
    """The command with these arguments."""
    return run


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """Three short demonstrations of valve-v1 with images, in a folder of this name."""

    def named(layout: str, name: str = "out", *, jobs: int = 1) -> Path:
        return write(tmp_path / name, layout, jobs=jobs)

    return named


@pytest.fixture(scope="session")
def written_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """The same, written by one process, in a folder that tests read and do not change."""

    @cache
    def folder(layout: str) -> Path:
        return write(tmp_path_factory.mktemp(layout) / "out", layout)

    return folder


@pytest.fixture(scope="session")
def lerobot(written_once: Callable[[str], Path]) -> Path:
    """The same for LeRobot."""
    return written_once("lerobot")


@pytest.fixture(scope="session")
def of_minari(written_once: Callable[[str], Path]) -> Path:
    """The same for Minari."""
    return written_once("minari")

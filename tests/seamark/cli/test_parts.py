"""`seamark run` with further programs, and the archive that computes such a run again."""

import json
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from seamark.cli import options
from seamark.cli.main import cli
from seamark.programs import parts
from seamark.sim import registry
from tests.part_programs import BENCHMARK, DETECTOR, TRACKER


def seamark(*arguments: object) -> Result:
    return CliRunner().invoke(cli, list(map(str, arguments)), prog_name="seamark")


QUICK = {**registry.benchmark(BENCHMARK).quick_settings, "loop1_values": [0.2]}


def run(*arguments: str | int | Path) -> tuple[int, str]:
    Path("quick.json").write_text(json.dumps(QUICK))
    done = seamark("run", BENCHMARK, "--config", "quick.json", "--seed", 3, *arguments)
    return done.exit_code, done.output


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("find.py").write_bytes(DETECTOR)
    Path("follow.py").write_bytes(TRACKER)


def test_the_command_line_has_an_option_for_every_role() -> None:
    assert options.PARTS == parts.ROLES


@pytest.mark.host
@pytest.mark.slow
def test_an_archived_run_with_parts_is_computed_again_with_them() -> None:
    own = ("--detector-program", "find.py", "--tracker-program", "follow.py")
    code, printed = run(*own, "--out", "result")
    assert code == 0, printed
    export = ("export", "result", "--format", "archive", "-o", "run.zip")
    assert seamark(*export, *own).exit_code == 0

    same = seamark("rerun", "run.zip")
    with zipfile.ZipFile("run.zip") as before, zipfile.ZipFile("other.zip", "w") as after:
        for name in before.namelist():
            content = before.read(name)
            after.writestr(name, content + b"# other" if name.endswith("find.py") else content)
    other = seamark("rerun", "other.zip")
    assert seamark(*export).exit_code == 0
    without = seamark("rerun", "run.zip")

    assert "looking for SEAMARK" in Path("result/log.txt").read_text()
    assert (same.exit_code, "Every number is the same." in same.stdout) == (0, True), same.output
    assert "detector: the SHA-256 is" in other.stdout
    assert "The archive does not have the detector of the run" in without.output


@pytest.mark.host
@pytest.mark.slow
def test_a_part_that_fails_is_named() -> None:
    Path("find.py").write_bytes(DETECTOR.replace(b"return []", b"return 1 / 0"))

    code, printed = run("--detector-program", "find.py")

    assert code == 1
    assert "Failed (user_error): The detector: ZeroDivisionError" in printed


def test_a_benchmark_without_parts_takes_none() -> None:
    done = seamark("run", "currents-v2", "--detector-program", "find.py")

    assert done.exit_code == 2
    assert "currents-v2 takes no program as its detector: it has none." in done.output


def test_a_part_has_to_be_a_program_of_its_role() -> None:
    _, missing = run("--tracker-program", "nowhere.py")
    _, wrong = run("--tracker-program", "find.py")

    assert "There is no file nowhere.py." in missing
    assert "Tracker" in wrong

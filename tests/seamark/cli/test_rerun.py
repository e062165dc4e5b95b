"""`seamark export` and `seamark rerun`: an archived run comes out the same, or it says why not."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.formats import archive_reading
from seamark.formats.archive import FOLDER
from tests.hostile.uploads.archives import damaged, zipped

Change = Callable[[str], str]
PROGRAM = """\
class Controller:
    def __init__(self, config): ...
    def step(self, observation):
        return [0.3 * value for value in observation.error] + [0.0]
"""


def seamark(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(one) for one in arguments])


@pytest.fixture(scope="module")
def archive(results: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The archive of a result, on another machine: in a folder of its own."""
    file = tmp_path_factory.mktemp("elsewhere") / "run.zip"
    written = seamark("export", results / "pi", "--format", "archive", "-o", file)
    assert written.exit_code == 0, written.output
    return file


def unchanged(text: str) -> str:
    return text


def changed(archive: Path, tmp_path: Path, files: dict[str, Change | None]) -> Path:
    """Return a copy in which some files are changed, or missing."""
    copy = tmp_path / "changed.zip"
    with zipfile.ZipFile(archive) as before, zipfile.ZipFile(copy, "w") as after:
        for name in before.namelist():
            change = files.get(name.removeprefix(f"{FOLDER}/"), unchanged)
            if change is not None:
                after.writestr(name, change(before.read(name).decode()))
    return copy


def edited(name: str, value: object) -> Change:
    """Return the change that gives a JSON document another value."""
    return lambda text: json.dumps(json.loads(text) | {name: value})


@pytest.mark.slow
def test_an_archived_run_gives_the_same_digest(archive: Path) -> None:
    manifest = json.loads(zipfile.ZipFile(archive).read(f"{FOLDER}/manifest.json"))

    done = seamark("rerun", archive)

    assert done.exit_code == 0, done.output
    assert f"digest  {manifest['digest']}\nEvery number is the same." in done.stdout


def one_number(text: str) -> str:
    """Change a single position of the vehicle, in the row 200."""
    lines = text.splitlines(keepends=True)
    head = next(at for at, line in enumerate(lines) if not line.startswith("#")) + 1
    row = lines[head + 200].split(",")
    row[3] = "0.125"
    lines[head + 200] = ",".join(row)
    return "".join(lines)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "change", "says"),
    [
        ("manifest.json", edited("digest", "0" * 64), "digest: 000000000000… in the archive, "),
        ("config.json", edited("ki", 0.3), "configuration: ki is 0.3 in config.json and"),
        ("metrics.json", edited("score", 1e9), "metrics: score is 1000000000.0 in the archive"),
        (
            "telemetry.csv",
            one_number,
            "first in row 200 from 0 (trial 1, t = 2 s), column x [m]: 0.125",
        ),
        (
            "telemetry.csv",
            lambda text: "".join(text.splitlines(keepends=True)[:-3]),
            "telemetry: 477 rows in the archive, 480 here",
        ),
    ],
)
def test_what_differs_is_named(
    archive: Path, tmp_path: Path, file: str, change: Change, says: str
) -> None:
    done = seamark("rerun", changed(archive, tmp_path, {file: change}))

    assert done.exit_code == 1
    assert says in done.stdout
    assert "The result differs." in done.stdout


@pytest.mark.slow
def test_other_software_is_named_and_is_no_difference_if_the_numbers_are_the_same(
    archive: Path, tmp_path: Path
) -> None:
    def older(text: str) -> str:
        manifest = json.loads(text)
        manifest["versions"]["numpy"] = "1.0"
        return json.dumps(manifest | {"code_sha256": "a" * 64})

    done = seamark("rerun", changed(archive, tmp_path, {"manifest.json": older}), "--json")

    report = json.loads(done.stdout)
    assert (done.exit_code, report["same"]) == (0, True)
    assert report["software"][0].startswith('version of numpy: "1.0" in the archive')
    assert report["software"][1].startswith("code of the simulator: aaaaaaaaaaaa… in the archive")


@pytest.mark.slow
def test_an_archive_from_when_pybullet_computed_contacts_says_so(
    archive: Path, tmp_path: Path
) -> None:
    def older(text: str) -> str:
        return json.dumps(json.loads(text) | {"contacts": "simulated"})

    result = seamark("rerun", changed(archive, tmp_path, {"manifest.json": older}))

    assert result.exit_code == 0
    assert "computed by PyBullet in the archive, computed by Seamark here" in result.output


@pytest.mark.host
def test_a_program_in_the_archive_runs_in_the_box_and_gives_the_same_digest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(PROGRAM)
    short = ("--set", "levels=0.1", "--set", "level_duration_s=3", "--set", "settle_s=1")
    options = ("--controller", "mine.py", *short, "--seed", 3, "--out", "result")
    assert seamark("run", "currents-v1", *options).exit_code == 0
    export = ("export", "result", "--format", "archive", "-o", "run.zip")
    assert seamark(*export, "--program", "mine.py").exit_code == 0

    same = seamark("rerun", "run.zip")
    Path("run.zip").rename("before.zip")
    tampered = changed(
        Path("before.zip"), tmp_path, {"program/mine.py": lambda text: text.replace("0.3", "0.2")}
    )
    other = seamark("rerun", tampered)
    assert seamark(*export).exit_code == 0
    without = seamark("rerun", "run.zip")

    assert same.exit_code == 0, same.output
    assert "Every number is the same." in same.stdout
    assert other.exit_code == 1
    assert "program: the SHA-256 is" in other.stdout
    assert "digest: " in other.stdout
    assert without.exit_code == 2
    assert "The archive has no program" in without.output


@pytest.mark.slow
@pytest.mark.parametrize(
    ("files", "says"),
    [
        ({"manifest.json": None}, "has no manifest.json"),
        ({"config.json": None}, "config.json is missing"),
        ({"telemetry.csv": None}, "telemetry.csv is missing"),
        ({"manifest.json": lambda _: "[" * 100_000}, "is not JSON"),
        ({"manifest.json": edited("trials", 10**9)}, "manifest.json: trials"),
        ({"manifest.json": edited("seed", None)}, "The seeds of this ranked run are hidden"),
        ({"manifest.json": edited("benchmark", "\x1b[2J")}, "There is no benchmark"),
        ({"manifest.json": edited("controller", "/bin/sh")}, "There is no built-in solution"),
        ({"config.json": edited("level_duration_s", 1e300)}, "config.json: "),
        ({"telemetry.csv": lambda _: "trial\n" + "1" * 100_000}, "a line is too long"),
        ({"telemetry.csv": lambda _: "#\n" * 2000 + "trial\n"}, "it has no columns"),
        ({"telemetry.csv": lambda _: "a,b\n1\n"}, "instead of 2"),
    ],
)
def test_an_archive_that_is_none_is_refused_with_a_reason(
    archive: Path, tmp_path: Path, files: dict[str, Change | None], says: str
) -> None:
    refused = seamark("rerun", changed(archive, tmp_path, files))

    assert refused.exit_code == 2
    assert says in refused.output
    assert "\x1b" not in refused.output


@pytest.mark.parametrize("bridge", ["rosbridge", "ardusub"])
def test_a_run_whose_program_was_connected_says_how_to_repeat_it(
    archive: Path, tmp_path: Path, bridge: str
) -> None:
    def connected(text: str) -> str:
        told = {"controller": bridge, "same_bits_on_every_cpu": False}
        return json.dumps(json.loads(text) | told)

    refused = seamark("rerun", changed(archive, tmp_path, {"manifest.json": connected}))

    assert refused.exit_code == 2
    assert f"was connected by {bridge} and is not in the archive" in refused.output
    command = f"seamark bridge {bridge} currents-v1 --config config.json --seed 7 --trials 3"
    assert command in refused.output


@pytest.mark.parametrize(
    ("file", "name", "value"),
    [
        ("manifest.json", "controller", "\x1b]0;x\x07\u202e"),
        ("manifest.json", "benchmark", "\x1b]0;x\x07\u202e"),
        ("config.json", "\x1b]0;x\x07\u202e", 1),
        ("config.json", "vehicle", "\x1b]0;x\x07\u202e"),
    ],
)
def test_no_text_of_an_archive_acts_on_the_terminal(
    archive: Path, tmp_path: Path, file: str, name: str, value: object
) -> None:
    refused = seamark("rerun", changed(archive, tmp_path, {file: edited(name, value)}))

    assert refused.exit_code == 2
    assert refused.output.replace("\n", "").isprintable()


def test_a_file_that_is_no_archive_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.zip").write_bytes(b"PK\x03\x04 and no more")

    refused = seamark("rerun", tmp_path / "run.zip")

    assert refused.exit_code == 2
    assert "cannot be read" in refused.output


def test_an_archive_with_damaged_compressed_data_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.zip").write_bytes(zipped(damaged(b"run/manifest.json")))

    refused = seamark("rerun", tmp_path / "run.zip")

    assert refused.exit_code == 2
    assert "cannot be read" in refused.output


def test_a_bomb_costs_no_more_than_the_limit_of_a_document(archive: Path, tmp_path: Path) -> None:
    limit = archive_reading.DOCUMENT_BYTES
    bomb = tmp_path / "bomb.zip"
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as file:
        with file.open("run/manifest.json", "w", force_zip64=True) as entry:
            for _ in range(20):
                entry.write(b" " * (limit // 10))
        file.writestr("../../etc/passwd", "nothing is unpacked")

    refused = seamark("rerun", bomb)

    assert refused.exit_code == 2
    assert "run/manifest.json is larger than 16 MiB" in refused.output


def test_a_list_of_many_files_is_not_even_read(tmp_path: Path) -> None:
    crowded = tmp_path / "crowded.zip"
    with zipfile.ZipFile(crowded, "w") as file:
        for number in range(1500):
            file.writestr(f"run/{number}", "")

    refused = seamark("rerun", crowded)

    assert refused.exit_code == 2
    assert "its list of files is too long" in refused.output


def test_a_result_is_exported_in_each_format_under_its_own_name(
    results: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    csv = pd.read_csv(results / "pi" / "telemetry.csv", comment="#")

    for kind in ("csv", "parquet", "npz"):
        done = seamark("export", results / "pi", "--format", kind, "--json")
        name = f"pi-telemetry.{kind}"
        told = {"out": name, "format": kind, "bytes": Path(name).stat().st_size}
        assert (done.exit_code, json.loads(done.stdout)) == (0, told)
    parquet = pd.read_parquet("pi-telemetry.parquet")
    npz = np.load("pi-telemetry.npz")["telemetry"]

    assert parquet.to_numpy().tobytes() == csv.to_numpy().tobytes() == npz.tobytes()
    again = pd.read_csv("pi-telemetry.csv", comment="#")
    assert again.equals(csv)


def test_export_refuses_what_is_no_result_and_leaves_no_file(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    out = tmp_path / "out"

    empty = seamark("export", tmp_path / "empty", "--format", "npz", "-o", out)
    nothing = seamark("export", tmp_path / "nothing", "--format", "npz", "-o", out)

    assert (empty.exit_code, nothing.exit_code) == (2, 2)
    assert "is not the result of a finished run" in empty.output
    assert "is neither a folder nor the number of a run" in nothing.output
    assert [one.name for one in tmp_path.iterdir()] == ["empty"]

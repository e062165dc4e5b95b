"""`seamark vehicle`, and runs with a user's own vehicle from the command line to the archive."""

import json
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.formats.archive import FOLDER
from seamark.sim.registry import ARMS, VEHICLES
from seamark.sim.vehicles import load
from seamark.sim.vehicles.urdf import urdf_of

MINE = """
format = 1
name = "mine"
title = "Mine"
summary = "The second BlueROV2 Heavy under another name."
extends = "bluerov2-heavy-v2"
"""
SHORT = ("tracker=truth", "levels=0.2", "level_duration_s=4", "settle_s=1")


def seamark(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(one) for one in arguments])


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    path = tmp_path / "mine.toml"
    path.write_text(MINE, encoding="utf-8")
    return path


@pytest.mark.parametrize("name", VEHICLES)
def test_a_vehicle_of_ours_is_checked_by_its_name(name: str) -> None:
    done = seamark("vehicle", "check", name)

    assert done.exit_code == 0, done.output
    assert f"{load(name).title} ({name})" in done.stdout
    assert "full thrust" in done.stdout
    assert "0 errors," in done.stdout


def test_a_file_is_checked_and_drawn(mine: Path, tmp_path: Path) -> None:
    picture = tmp_path / "mine.svg"

    done = seamark("vehicle", "check", mine, "--draw", picture)

    assert done.exit_code == 0, done.output
    assert "ahead                    88.25 N     1.21 m/s" in done.stdout
    assert "drag quadratic x" in done.stdout
    assert "56.5 N s²/m², from 18.18 to 141" in done.stdout
    assert ElementTree.parse(picture).getroot().tag.endswith("svg")  # noqa: S314  # our own text


@pytest.mark.parametrize("name", ARMS)
def test_an_arm_of_ours_is_checked_by_its_name(name: str) -> None:
    done = seamark("vehicle", "check", name)

    assert done.exit_code == 0, done.output
    assert f"({name})" in done.stdout
    assert "top speed" in done.stdout
    assert "0 errors," in done.stdout


def test_a_file_of_an_arm_is_checked_and_drawn(tmp_path: Path) -> None:
    mine, picture = tmp_path / "arm.toml", tmp_path / "arm.svg"
    mine.write_bytes(ARMS["alpha-like"].read_bytes())

    done = seamark("vehicle", "check", mine, "--draw", picture, "--json")

    assert done.exit_code == 0, done.output
    figures = json.loads(done.stdout)["figures"]
    assert figures["reach_m"] == pytest.approx(0.409, abs=0.001)
    assert figures["joints"][0]["payload_n"] is None  # it turns about the vertical
    assert ElementTree.parse(picture).getroot().tag.endswith("svg")  # noqa: S314  # our own text


def test_the_urdf_of_an_arm_is_imported_and_can_be_checked(tmp_path: Path) -> None:
    urdf, out = tmp_path / "arm.urdf", tmp_path / "arm.toml"
    inertia = '<inertia ixx="0.01" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/>'
    urdf.write_text(
        '<robot name="lifter"><link name="base"/><link name="lift"><inertial><mass value="1"/>'
        f'{inertia}</inertial></link><joint name="j" type="revolute"><parent link="base"/>'
        '<child link="lift"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="20" velocity="0.4"/></joint></robot>',
        encoding="utf-8",
    )

    done = seamark("vehicle", "import", urdf, "-o", out, "--arm")
    checked = seamark("vehicle", "check", out)

    assert done.exit_code == 0, done.output
    assert checked.exit_code == 0, checked.output
    assert "lifter (lifter), 1 motor" in checked.stdout
    assert "the arm can touch nothing" in checked.stdout


def test_a_mistake_in_the_file_of_an_arm_is_a_sentence(tmp_path: Path) -> None:
    mine = tmp_path / "arm.toml"
    text = ARMS["hook"].read_text("utf-8")
    mine.write_text(text.replace("[-2.094395, 1.047198]", "[1.0, -1.0]"), encoding="utf-8")

    done = seamark("vehicle", "check", mine)

    assert done.exit_code == 1
    assert "joint.range must be its lower end, then its upper one" in done.stdout


def test_a_mistake_is_exit_code_1_with_a_sentence(mine: Path) -> None:
    mine.write_text(MINE + '[body]\nmass = { value = 1, unit = "g", tag = "E", reason = "?" }\n')

    done = seamark("vehicle", "check", mine)

    assert done.exit_code == 1
    assert (
        "error    body.mass.unit must be \"kg\", not 'g': numbers are not converted." in done.stdout
    )


def test_a_body_that_cannot_exist_is_exit_code_1_without_figures(mine: Path) -> None:
    inertia = 'inertia = { value = [9, 1, 1], unit = "kg m²", tag = "E", reason = "?" }'
    mine.write_text(f"{MINE}[body]\n{inertia}\n", encoding="utf-8")

    done = seamark("vehicle", "check", mine)

    assert done.exit_code == 1
    assert "triangle inequality" in done.stdout
    assert "full thrust" not in done.stdout
    assert "1 error, 1 warning." in done.stdout


def test_a_program_can_read_the_report(mine: Path) -> None:
    done = seamark("vehicle", "check", mine, "--json")

    document = json.loads(done.stdout)
    assert document["name"] == "mine"
    assert document["errors"] == []
    assert document["figures"]["full_thrust"]["ahead"]["speed"] == pytest.approx(1.2146, abs=1e-4)
    assert {one["place"] for one in document["figures"]["spreads"]} >= {"drag quadratic x"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("check", "submarine"), "neither a file nor one of our vehicles and arms: girona500"),
        (("check", "girona500", "--draw", "x.png"), "drawings are SVG"),
        (("import", __file__, "-o", __file__), "exists: choose another file"),
        (("import", __file__, "-o", "new.toml"), "not valid XML"),
    ],
)
def test_wrong_usage_is_told(arguments: tuple[str, ...], said: str) -> None:
    done = seamark("vehicle", *arguments)

    assert done.exit_code == 2
    assert said in done.output


def test_an_imported_urdf_can_be_checked_and_run(tmp_path: Path) -> None:
    urdf, toml = tmp_path / "rov.urdf", tmp_path / "rov.toml"
    urdf.write_text(urdf_of(load("bluerov2-heavy")), encoding="utf-8")

    imported = seamark("vehicle", "import", urdf, "-o", toml, "--z-down")

    assert imported.exit_code == 0, imported.output
    assert f"seamark vehicle check {toml}" in imported.stdout
    assert tomllib.loads(toml.read_text("utf-8"))["name"] == "my-bluerov2-heavy"
    assert seamark("vehicle", "check", toml).exit_code == 0


def settings() -> list[str]:
    return [word for pair in SHORT for word in ("--set", pair)]


def run(vehicle: object, out: Path) -> Result:
    return seamark(
        *("run", "currents-v1", "--controller", "pi", "--seed", 7, "--out", out),
        *("--set", f"vehicle={vehicle}", *settings()),
    )


@pytest.mark.slow
def test_a_file_with_the_numbers_of_our_vehicle_gives_the_same_bits(
    mine: Path, tmp_path: Path
) -> None:
    here, there = run(mine, tmp_path / "mine"), run("bluerov2-heavy-v2", tmp_path / "ours")

    assert (here.exit_code, there.exit_code) == (0, 0), here.output + there.output
    digests = [
        json.loads((tmp_path / name / "manifest.json").read_text("utf-8"))["digest"]
        for name in ("mine", "ours")
    ]
    assert digests[0] == digests[1]


@pytest.mark.slow
def test_an_archived_run_brings_its_vehicle_along(mine: Path, tmp_path: Path) -> None:
    assert run(mine, tmp_path / "result").exit_code == 0
    archive = tmp_path / "run.zip"
    assert (
        seamark("export", tmp_path / "result", "--format", "archive", "-o", archive).exit_code == 0
    )
    mine.unlink()

    done = seamark("rerun", archive)

    assert done.exit_code == 0, done.output
    assert "Every number is the same." in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("Mine", "Other", "another one than that of its configuration"),
        ("format = 1", "format = 2", "The vehicle in the archive: format must be 1"),
    ],
)
def test_an_archive_with_another_vehicle_is_refused(
    mine: Path, tmp_path: Path, before: str, after: str, said: str
) -> None:
    assert run(mine, tmp_path / "result").exit_code == 0
    archive, changed = tmp_path / "run.zip", tmp_path / "changed.zip"
    assert (
        seamark("export", tmp_path / "result", "--format", "archive", "-o", archive).exit_code == 0
    )
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            text = old.read(name).decode()
            if name == f"{FOLDER}/manifest.json":
                document = json.loads(text)
                file = document["vehicle_file"]
                file["text"] = file["text"].replace(before, after)
                text = json.dumps(document)
            new.writestr(name, text)

    done = seamark("rerun", changed)

    assert done.exit_code == 2
    assert said in done.output


def test_a_broken_file_is_one_sentence_when_a_run_starts(mine: Path, tmp_path: Path) -> None:
    mine.write_text("format = 1\n", encoding="utf-8")

    done = run(mine, tmp_path / "result")

    assert done.exit_code == 2
    assert f"{mine}: body is missing: write a line [body], and its keys below." in done.output
    assert f"more: `seamark vehicle check {mine}`" in done.output


@pytest.mark.slow
def test_tuned_settings_name_the_file_of_the_vehicle(mine: Path, tmp_path: Path) -> None:
    out = tmp_path / "tuned.toml"

    done = seamark(
        *("tune", "currents-v1", "--controller", "pi", "--param", "kp=0.3:0.6", "--out", out),
        *("--candidates", 2, "--trials", 1, "--validate", 0, "--set", f"vehicle={mine}"),
        *settings(),
    )

    assert done.exit_code == 0, done.output
    assert tomllib.loads(out.read_text("utf-8"))["vehicle"] == str(mine)

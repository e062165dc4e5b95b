"""`seamark identify` as a user calls it: a log and a vehicle in, a vehicle's file out."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from performance.statistics.identification.tank_day import log_of, write_csv
from seamark.cli.main import cli
from seamark.identification.parameters import parameters_of
from seamark.sim.vehicles import load
from seamark.sim.vehicles.reading import read_vehicle

SECONDS = 12.0
OWN = """format = 1
name = "my-rov" # a comment stays
title = "My ROV"
summary = "As bought."
extends = "bluerov2-heavy-v2"

[sources]
data = "data sheet"

[body]
drag_linear = [ # guessed
  { axes = ["x", "y", "z"], value = [8.0, 8.0, 8.0], unit = "N s/m", tag = "S", source = "data" },
  { axes = ["roll", "pitch", "yaw"], value = [0.1, 0.1, 0.1], unit = "N m s", tag = "E", reason = "guess" },
]
"""  # noqa: E501  # as people write it


def identify(*arguments: object) -> tuple[int, str]:
    done = CliRunner().invoke(cli, ["identify", *map(str, arguments)])
    return done.exit_code, done.output


@pytest.fixture(scope="module")
def tank(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("tank") / "tank.csv"
    write_csv(log_of(load("bluerov2-heavy-v2"), 7, seconds=SECONDS), path)
    return path


@pytest.mark.slow
def test_a_tank_day_gives_a_vehicle_that_a_run_can_have(tank: Path, tmp_path: Path) -> None:
    mine, fitted = tmp_path / "my.toml", tmp_path / "fitted.toml"
    mine.write_text(OWN, encoding="utf-8")

    code, output = identify(tank, "--vehicle", mine, "--out", fitted)

    assert code == 0, output
    assert "surge, quadratic drag" in output
    vehicle = read_vehicle(fitted.read_bytes(), base=load)
    assert vehicle.name == "my-rov"
    truth = parameters_of(load("bluerov2-heavy-v2"))
    assert parameters_of(vehicle) == pytest.approx(truth, rel=0.02, abs=0.01)
    text = fitted.read_text(encoding="utf-8")
    assert "# a comment stays" in text
    assert re.search(r"95 % interval [0-9.]+ to [0-9.]+, before 8", text)
    run = CliRunner().invoke(
        cli,
        [
            *("run", "currents-v2", "--controller", "pi", "--set", f"vehicle={fitted}"),
            *("--set", "levels=0.2", "--set", "level_duration_s=4", "--set", "settle_s=1"),
        ],
    )
    assert run.exit_code == 0, run.output


@pytest.mark.slow
def test_the_telemetry_of_a_run_is_a_log(tmp_path: Path) -> None:
    result = tmp_path / "result"
    run = CliRunner().invoke(
        cli,
        [
            *("run", "currents-v2", "--controller", "pi", "--seed", "3", "--out", str(result)),
            *("--set", "vehicle=bluerov2-heavy-v2", "--set", "levels=0,0.4"),
            *("--set", "level_duration_s=12", "--set", "settle_s=1"),
        ],
    )
    assert run.exit_code == 0, run.output

    code, output = identify(result / "telemetry.csv", "--vehicle", "bluerov2-heavy-v2", "--json")

    assert code == 0, output
    document = json.loads(output)
    assert document["driven_by"] == "thrusts"
    assert any(one["fitted"] for one in document["parameters"])
    for one in document["predictions"]:
        assert one["rms_after"] <= one["rms_before"] * 1.01


def rewritten(tank: Path, tmp_path: Path, change: dict[int, str]) -> Path:
    lines = tank.read_text(encoding="utf-8").split("\n")
    for at, line in change.items():
        lines[at] = line
    path = tmp_path / "other.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def cells(tank: Path, line: int) -> list[str]:
    return tank.read_text(encoding="utf-8").split("\n")[line].split(",")


def test_a_row_out_of_order_is_named(tank: Path, tmp_path: Path) -> None:
    log = rewritten(tank, tmp_path, {5: ",".join(cells(tank, 3))})

    code, output = identify(log, "--vehicle", "bluerov2-heavy-v2")

    assert code == 2
    assert "Line 6" in output
    assert "Sort the log by time" in output


@pytest.mark.parametrize(
    ("column", "text", "said"),
    [
        ("command_0", "", "command_0 is missing or nan"),
        ("command_0", "1500", "commands are from -1 to 1"),
        ("u", "inf", "u is infinite"),
        ("u", "fast", "'fast' is not a number"),
    ],
)
def test_a_wrong_cell_is_named(
    tank: Path, tmp_path: Path, column: str, text: str, said: str
) -> None:
    row = cells(tank, 9)
    row[cells(tank, 0).index(column)] = text
    log = rewritten(tank, tmp_path, {9: ",".join(row)})

    code, output = identify(log, "--vehicle", "bluerov2-heavy-v2")

    assert code == 2
    assert "Line 10" in output
    assert said in output


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("command_3", "unknown", "no command_3"),
        ("command", "unknown", "does not say what drove the vehicle"),
        ("t,u", "time of day,u", "no column t"),
    ],
)
def test_a_missing_column_is_named(
    tank: Path, tmp_path: Path, old: str, new: str, said: str
) -> None:
    header = tank.read_text(encoding="utf-8").split("\n")[0].replace(old, new)
    log = rewritten(tank, tmp_path, {0: header})

    code, output = identify(log, "--vehicle", "bluerov2-heavy-v2")

    assert code == 2
    assert said in output


def test_a_log_of_none_of_the_velocities_is_refused(tank: Path, tmp_path: Path) -> None:
    header = tank.read_text(encoding="utf-8").split("\n")[0]
    named = ",".join(f"x_{one}" if one in "uvwpqr" else one for one in header.split(","))
    log = rewritten(tank, tmp_path, {0: named})

    code, output = identify(log, "--vehicle", "bluerov2-heavy-v2")

    assert code == 2
    assert "none of the velocities" in output


def test_an_existing_file_is_not_overwritten(tank: Path, tmp_path: Path) -> None:
    kept = tmp_path / "kept.toml"
    kept.write_text("kept", encoding="utf-8")

    code, output = identify(tank, "--vehicle", "bluerov2-heavy-v2", "--out", kept)

    assert code == 2
    assert "exists" in output
    assert kept.read_text(encoding="utf-8") == "kept"

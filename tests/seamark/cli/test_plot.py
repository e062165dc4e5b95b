"""`seamark plot`: what is drawn, in a terminal, in a pipe and as a picture."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.plots.charts import Chart, Line
from seamark.plots.terminal import text


def seamark(*arguments: str) -> Result:
    return CliRunner().invoke(cli, arguments, prog_name="seamark")


def test_results_are_drawn_over_each_other_in_eighty_columns(results: Path) -> None:
    answer = seamark("plot", str(results / "pi"), str(results / "p"))

    assert answer.exit_code == 0
    assert max(map(len, answer.output.splitlines())) <= 80
    for title in ("Distance from the station [m]", "Current, the same for all", "Path of the"):
        assert title in answer.output
    assert "a: pi  b: p" in answer.output
    assert "\x1b" not in answer.output


def test_the_document_has_the_numbers_of_the_telemetry(results: Path) -> None:
    answer = seamark("plot", str(results / "pi"), "--only", "error", "--only", "levels", "--json")

    error, levels = json.loads(answer.output)["charts"]
    lines = [
        line
        for line in (results / "pi" / "telemetry.csv").read_text().splitlines()
        if not line.startswith("#")
    ]
    at = lines[0].split(",").index("distance")
    recorded = [float(line.split(",")[at]) for line in lines[1:] if line.startswith("0,")]
    metrics = json.loads((results / "pi" / "metrics.json").read_text())
    assert error["lines"][0]["y"] == recorded
    assert levels["lines"][0]["x"] == [0.0, 0.3]
    assert levels["lines"][0]["y"] == [level["rmse_m"] for level in metrics["levels"]]


def test_a_run_of_a_detector_is_drawn_by_its_path_and_levels_as_it_has_no_error(
    tmp_path: Path,
) -> None:
    settings = ("--set", "optical_depths=0", "--set", "level_duration_s=2")
    folder = str(tmp_path / "r")
    seamark("run", "patterns-v1", *settings, "--out", folder)

    every = seamark("plot", folder, "--json")
    error = seamark("plot", folder, "--only", "error")

    titles = [chart["title"] for chart in json.loads(every.output)["charts"]]
    assert titles == ["Path of the vehicle from above [m]", "Average precision [%] of each level"]
    assert error.exit_code == 2
    assert "Runs of patterns-v1 have no chart of this kind" in error.output


def test_a_run_with_an_arm_is_drawn_by_how_far_its_tool_is_from_the_grip(tmp_path: Path) -> None:
    settings = ("--set", "levels=0.1", "--set", "level_duration_s=2")
    seamark("run", "recover-v1", "--controller", "nothing", *settings, "--out", str(tmp_path / "r"))

    answer = seamark("plot", str(tmp_path / "r"), "--only", "error", "--json")

    [error] = json.loads(answer.output)["charts"]
    assert error["title"] == "Distance of the tool from the grip [m]"
    assert 1.0 < min(error["lines"][0]["y"]) < max(error["lines"][0]["y"]) < 3.0


@pytest.mark.slow
def test_a_picture_is_written_without_a_window(results: Path, tmp_path: Path) -> None:
    answer = seamark(
        "plot", str(results / "pi"), str(results / "p"), "--out", str(tmp_path / "x.png")
    )

    picture = cv2.imread(str(tmp_path / "x.png"))
    assert answer.exit_code == 0
    assert picture is not None
    assert min(picture.shape[:2]) > 500
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("none",), "none is neither a folder nor the number of a run"),
        (("empty",), "is not the result of a finished run"),
        (("pi", "--trial", "4"), "pi has 3 trials"),
        (("pi", "--out", "x.bmp"), "name it .png, .pdf or .svg"),
        (("pi", "--out", "none/x.png"), "cannot be written"),
        (("pi",) * 6, "Up to 5 results"),
    ],
)
def test_what_cannot_be_plotted_is_refused(
    results: Path, arguments: tuple[str, ...], message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(results)
    Path("empty").mkdir(exist_ok=True)

    answer = seamark("plot", *arguments)

    assert answer.exit_code == 2
    assert message in " ".join(answer.output.split())


def test_a_damaged_telemetry_is_refused_with_a_sentence(results: Path, tmp_path: Path) -> None:
    for name in ("manifest.json", "metrics.json"):
        (tmp_path / name).write_bytes((results / "pi" / name).read_bytes())
    header = (results / "pi" / "telemetry.csv").read_text().partition("\n0,")[0]
    for damaged in ("", "# only\n", "trial,level\n1,2\n", header, "\xff"):
        (tmp_path / "telemetry.csv").write_text(damaged, encoding="latin-1")

        answer = seamark("plot", str(tmp_path))

        assert answer.exit_code == 2, answer.output
        assert "is not the result of a finished run" in " ".join(answer.output.split())


def _chart(y: list[float], **more: bool) -> Chart:
    line = Line("one", np.arange(float(len(y))), np.array(y))
    return Chart(title="T", x_label="x", y_label="y", lines=(line,), **more)


@pytest.mark.parametrize(
    "y", [[0.0], [1.0, 1.0], [float("nan"), 2.0, float("inf")], [1e-9, 1e9], [-3e-5, 2e-5], [5e8]]
)
@pytest.mark.parametrize("more", [{}, {"logarithmic": True}, {"equal": True}])
def test_every_line_fits_into_its_axes(y: list[float], more: dict[str, bool]) -> None:
    drawn = text(_chart(y, **more), columns=80, coloured=False)

    assert max(map(len, drawn.splitlines())) <= 80
    assert any("\N{BRAILLE PATTERN BLANK}" < sign <= "\u28ff" for sign in drawn)


def test_what_was_not_recorded_is_said() -> None:
    assert "nothing recorded" in text(_chart([float("nan")]), columns=80, coloured=False)


def test_lines_have_colours_on_a_terminal_and_gaps_are_not_bridged(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")  # the output of a test is no terminal
    whole = text(_chart([0.0, 1.0, 2.0, 3.0]), columns=60, coloured=True)
    broken = text(_chart([0.0, 1.0, float("nan"), 3.0]), columns=60, coloured=True)

    dots = [sum("\u2800" < sign <= "\u28ff" for sign in drawn) for drawn in (whole, broken)]
    assert "\x1b[32m" in whole
    assert dots[1] < 0.6 * dots[0]


def test_help_does_not_load_plotting() -> None:
    code = (
        "import sys; from seamark.cli.main import cli\n"
        "cli.main(['plot', '--help'], standalone_mode=False)\n"
        "assert not {'numpy', 'matplotlib', 'plotille'} & set(sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)

    assert done.returncode == 0, done.stderr

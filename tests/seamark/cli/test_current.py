"""`seamark current`, and runs with a record of one's own from the command line to the archive."""

import json
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.formats.archive import FOLDER

SHORT = ("tracker=truth", "levels=0.2", "level_duration_s=4", "settle_s=1")
METER = "time_s,height_m,u_cm_s,v_cm_s\n" + "".join(
    f"{10 * i},{h},{20 + i % 7},{5 * h}\n" for i in range(60) for h in (1, 2)
)


def seamark(*arguments: object) -> Result:
    return CliRunner().invoke(cli, [str(one) for one in arguments])


@pytest.fixture
def meter(tmp_path: Path) -> Path:
    path = tmp_path / "meter.csv"
    path.write_text(METER, encoding="utf-8")
    return path


def test_a_file_is_described_drawn_and_made_a_record(meter: Path, tmp_path: Path) -> None:
    out, drawing = tmp_path / "record.csv", tmp_path / "record.svg"

    done = seamark("current", meter, "-o", out, "--draw", drawing, "--licence", "CC BY 4.0, us")

    assert done.exit_code == 0, done.output
    for words in ("read as   CSV", "an instant every 10 s", "heights   1, 2 m", "0.0% missing"):
        assert words in done.output
    assert "no vertical velocity" in done.output
    assert "# licence: CC BY 4.0, us" in out.read_text()
    root = ElementTree.fromstring(drawing.read_text())  # noqa: S314  # our own
    assert len(root.findall(".//{http://www.w3.org/2000/svg}polyline")) == 3
    again = seamark("current", meter, "-o", out)
    assert again.exit_code != 0
    assert "exists" in again.output


def test_json_has_what_the_text_says(meter: Path) -> None:
    done = seamark("current", meter, "--json")

    document = json.loads(done.output)
    assert document["heights_m"] == [1.0, 2.0]
    assert document["mean_m_s"]["north"] == pytest.approx([0.05, 0.1])
    assert document["missing"] == 0.0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("--tides",), "--begin"),
        (("-o", "record.txt"), "name with .csv"),
        (("--draw", "a.png"), "name with .svg"),
        (("--hours", "0.01"), "too few"),
        (("--step", "400"), "leaves 2 instants"),
    ],
)
def test_what_cannot_be_done_is_said(
    meter: Path, arguments: tuple[str, ...], sentence: str
) -> None:
    done = seamark("current", meter, *arguments)

    assert done.exit_code != 0
    assert sentence in done.output


@pytest.mark.slow
def test_a_run_with_a_record_is_computed_again_from_its_archive(
    meter: Path, tmp_path: Path
) -> None:
    record, result, archive = tmp_path / "r.csv", tmp_path / "result", tmp_path / "archive.zip"
    assert seamark("current", meter, "-o", record).exit_code == 0
    settings = [part for pair in (*SHORT, f"current_record={record}") for part in ("--set", pair)]

    run = seamark("run", "currents-v2", "--controller", "pi", *settings, "--out", result)

    assert run.exit_code == 0, run.output
    manifest = json.loads((result / "manifest.json").read_text())
    assert manifest["current_file"]["text"] == record.read_text()
    (stretch,) = json.loads((result / "metrics.json").read_text())["trials"][0]["conditions"][
        "stretches"
    ]
    assert stretch["factor"] * stretch["speed"] == pytest.approx(0.2)
    assert seamark("export", result, "--format", "archive", "-o", archive).exit_code == 0
    record.unlink()
    assert seamark("rerun", archive).exit_code == 0
    changed = tmp_path / "changed.zip"
    with zipfile.ZipFile(archive) as old, zipfile.ZipFile(changed, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith("manifest.json") and name.startswith(FOLDER):
                content = content.replace(b"10,1,0.0", b"10,1,0.1", 1)
            new.writestr(name, content)
    refused = seamark("rerun", changed)
    assert refused.exit_code != 0


def test_a_record_that_is_none_is_refused_before_the_run(tmp_path: Path) -> None:
    path = tmp_path / "bad.csv"
    path.write_text("time,u\n")

    done = seamark("run", "currents-v2", "--controller", "pi", "--set", f"current_record={path}")

    assert done.exit_code != 0
    assert "`seamark current FILE -o RECORD.csv` writes one" in " ".join(done.output.split())


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (("current_place=ria", "current_law=force"), "must be none when the current acts"),
        (("wave_height_m=0.5", "current_law=force"), "must be 0.0 when the current acts"),
        (("current_place=ria", "current_shear=0.1"), "a profile of their own"),
        (("current_place=lake",), "one of none, harbour, ria, channel, shelf"),
        (("current_record=other",), "one of none, synthetic-ria"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(
    settings: tuple[str, ...], sentence: str
) -> None:
    pairs = [part for pair in settings for part in ("--set", pair)]

    done = seamark("run", "currents-v1", "--controller", "pi", *pairs)

    assert done.exit_code != 0
    assert sentence in " ".join(done.output.split())

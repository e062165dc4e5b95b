"""A log without a mapping: usual names are taken for what they usually are, and that is told."""

import re
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seamark.mission_logs.guesses import guess_columns
from seamark.mission_logs.mapping import LogMapping
from seamark.mission_logs.measuring import measure
from seamark.mission_logs.result import LogRefused, LogResult
from seamark.sim.recording.telemetry import INDEX
from tests.seamark.mission_logs.conftest import POSE, Run
from tests.seamark.mission_logs.test_ros_logs import TOPICS, _folder, _messages

MAPPING = LogMapping.model_validate({"settings": {"settle_s": 1.0}})
BEGIN = datetime(2024, 5, 1, 12, 0, tzinfo=UTC)
Open = Callable[..., LogResult]


@pytest.fixture
def opened(run: Run, tmp_path: Path) -> Open:
    """Write the poses of a level under other names, as texts, and return what is measured."""

    def opened(
        names: dict[str, str],
        times: Callable[[int], str],
        *,
        delimiter: str = ",",
        write: Callable[[str, float], str] = lambda _name, value: repr(value),
        mapping: LogMapping = MAPPING,
    ) -> LogResult:
        single = run.level(1)
        columns = [single.column(name).tolist() for name in names]
        lines = [delimiter.join([*names.values(), "time"])]
        for at, values in enumerate(zip(*columns, strict=True)):
            cells = [write(name, value) for name, value in zip(names, values, strict=True)]
            lines.append(delimiter.join([*cells, times(at)]))
        (tmp_path / "log.csv").write_text("\n".join(lines))
        return measure(tmp_path / "log.csv", mapping, benchmark="currents-v1")

    return opened


def in_seconds(at: int) -> str:
    return repr(0.05 * at)


def same_names() -> dict[str, str]:
    return {name: name for name in POSE}


@pytest.mark.parametrize(
    "time",
    [
        lambda at: (BEGIN + timedelta(seconds=0.05 * at)).isoformat(),
        lambda at: f"{BEGIN + timedelta(seconds=0.05 * at):%Y-%m-%d %H:%M:%S.%f}",
        lambda at: f"{BEGIN + timedelta(seconds=0.05 * at):%Y-%m-%dT%H:%M:%S.%f}000Z",
        lambda at: str(1_714_564_800_000 + 50 * at),
        lambda at: str(1_714_564_800_000_000_000 + 50_000_000 * at),
        lambda at: repr(1_714_564_800 + 0.05 * at),
    ],
)
def test_times_are_read_as_loggers_write_them(run: Run, opened: Open, time: Any) -> None:
    found = opened(same_names(), time)

    np.testing.assert_allclose(found.rows[:, INDEX["t"]], 0.05 * np.arange(60), atol=1e-6)
    assert found.manifest["period_s"] == 0.05
    assert found.manifest["guessed"]["columns"]["t"]["name"] == "time"
    assert np.array_equal(found.rows[:, INDEX["x"]], run.level(1).column("x"))


def test_semicolons_with_decimal_commas_are_numbers(run: Run, opened: Open) -> None:
    def comma(_name: str, value: float) -> str:
        return repr(value).replace(".", ",")

    found = opened(
        same_names(), lambda at: f"{0.05 * at:.2f}".replace(".", ","), delimiter=";", write=comma
    )

    for name in POSE:
        assert np.array_equal(found.rows[:, INDEX[name]], run.level(1).column(name)), name


def test_usual_names_and_units_are_taken_for_columns_and_told(run: Run, opened: Open) -> None:
    names = dict(zip(POSE, ("Northing", "Easting", "Depth [cm]"), strict=False))
    names |= {"roll": "roll_deg", "pitch": "theta", "yaw": "Heading"}
    scale = {"z": 100.0, "roll": 180.0 / np.pi, "yaw": 180.0 / np.pi}

    found = opened(names, in_seconds, write=lambda name, value: repr(value * scale.get(name, 1.0)))

    for name in POSE:
        np.testing.assert_allclose(
            found.rows[:, INDEX[name]], run.level(1).column(name), rtol=1e-12, atol=1e-15
        )
    assert found.manifest["guessed"] == {
        "columns": {
            "x": {"name": "Northing", "unit": ""},
            "y": {"name": "Easting", "unit": ""},
            "z": {"name": "Depth [cm]", "unit": "cm"},
            "t": {"name": "time", "unit": ""},
            "roll": {"name": "roll_deg", "unit": "deg"},
            "pitch": {"name": "theta", "unit": ""},
            "yaw": {"name": "Heading", "unit": "deg"},
        }
    }


def test_what_a_mapping_says_is_not_guessed(run: Run, opened: Open) -> None:
    names = same_names() | {"yaw": "Heading"}
    columns = {"yaw": {"name": "Heading", "unit": "rad"}, "t": {"name": "time", "unit": "s"}}
    mapping = MAPPING.model_copy(
        update={"columns": LogMapping.model_validate({"columns": columns}).columns}
    )

    found = opened(names, in_seconds, mapping=mapping)

    assert np.array_equal(found.rows[:, INDEX["yaw"]], run.level(1).column("yaw"))
    assert found.manifest["guessed"] == {}


def test_in_enu_names_of_directions_are_other_axes(run: Run, opened: Open) -> None:
    names = {"y": "east", "x": "north", "z": "up", "roll": "roll", "pitch": "pitch", "yaw": "yaw"}
    turned = {"z": lambda v: -v, "pitch": lambda v: -v, "yaw": lambda v: 0.5 * np.pi - v}

    found = opened(
        names,
        in_seconds,
        write=lambda name, value: repr(float(turned.get(name, lambda v: v)(value))),
        mapping=MAPPING.model_copy(update={"frame": "ENU"}),
    )

    for name in POSE:
        np.testing.assert_allclose(
            found.rows[:, INDEX[name]], run.level(1).column(name), atol=1e-12
        )


def test_a_guessed_velocity_with_a_gap_is_left_out(opened: Open) -> None:
    names = same_names() | {"u": "surge"}

    found = opened(names, in_seconds, write=lambda name, value: "" if name == "u" else repr(value))

    assert "u" in found.manifest["absent"]
    assert "u" not in found.manifest["guessed"]["columns"]


@pytest.mark.parametrize(
    ("times", "sentence"),
    [
        (["2024-05-01T12:00:00Z", "noon"], "Line 3, column t: 'noon' is not a time by ISO 8601"),
        (["2024-05-01T12:00:00Z", "2024-05-01T12:00:01"], "Line 3, column t"),
        (["0.0", "2024-05-01T12:00:00Z"], "Line 3, column t: .* is not a number"),
        (["2024-05-01T12:00:00Z" + "0" * 9000] * 2, "Line 2, column t"),
    ],
)
def test_a_time_that_is_none_is_refused_with_its_line(
    tmp_path: Path, times: list[str], sentence: str
) -> None:
    (tmp_path / "log.csv").write_text("\n".join(["utc,x", *(f"{time},0" for time in times)]))

    with pytest.raises(LogRefused, match=sentence):
        measure(tmp_path / "log.csv", MAPPING, benchmark="currents-v1")


@pytest.mark.parametrize(("frame_id", "frame"), [("world", "ENU"), ("map_ned", "NED")])
def test_one_topic_of_odometry_needs_no_mapping(
    run: Run, tmp_path: Path, frame_id: str, frame: str
) -> None:
    single = run.level(1)
    kind, sent = _messages(single, old=False)[TOPICS["pose"]]
    for _, message in sent:
        message.header.__dict__["frame_id"] = frame_id

    found = measure(
        _folder(tmp_path, {TOPICS["pose"]: (kind, sent)}), MAPPING, benchmark="currents-v1"
    )

    topics = {"pose": TOPICS["pose"], "velocity": TOPICS["pose"]}
    assert found.manifest["guessed"] == {"frame": frame, "topics": topics}
    north = {"NED": "x", "ENU": "y"}[frame]
    assert np.array_equal(found.rows[:, INDEX["x"]], single.column(north))
    side = {"NED": 1.0, "ENU": -1.0}[frame]
    assert np.array_equal(found.rows[:, INDEX["v"]], side * single.column("v"))


def test_two_topics_of_odometry_are_listed(run: Run, tmp_path: Path) -> None:
    written = _messages(run.level(1), old=False)
    twice = {"/a": written[TOPICS["pose"]], "/b": written[TOPICS["pose"]]}

    with pytest.raises(LogRefused, match=r"several topics with a pose.*/a .*/b "):
        measure(_folder(tmp_path, twice), MAPPING, benchmark="currents-v1")


def test_the_names_in_the_documentation_are_guessed() -> None:

    text = (Path(__file__).parents[3] / "docs" / "logs.md").read_text("utf-8")
    table = text.partition("| column | usual names |")[2].partition("\n\n")[0]
    named = re.findall(r"^\| (`t`|`roll`[^|]*|`u`[^|]*) \| ([^|]*)", table, re.MULTILINE)

    assert len(named) == 3
    for columns, names in named:
        for name in re.findall(
            r"\b[a-z_]+\b", names.partition("; times")[0].partition("; left")[0]
        ):
            found = guess_columns([name], (), "NED")
            assert set(found) <= set(re.findall(r"\w+", columns)), name
            assert found or name in {"and", "which", "are", "in", "degrees"}, name

"""Telemetry reads back as it was written, for a vehicle with any number of thrusters."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import (
    COMMON_THRUSTERS,
    DELIVERED_ROWS,
    INDEX,
    NAMES,
    WIDTH,
    Digest,
    Recorder,
    Rows,
)
from seamark.sim.vehicles.reading import THRUSTERS_MAX
from tests import telemetry_csv

finite_rows = arrays(
    np.float64,
    st.tuples(st.integers(0, 3), st.integers(WIDTH, WIDTH + 3)),
    elements=st.floats(allow_nan=False, allow_infinity=False),
    fill=st.just(0.0),
)


def numbered(count: int, width: int = WIDTH) -> Rows:
    return np.arange(count * width, dtype=np.float64).reshape(count, width) / 7.0


def test_the_columns_are_those_of_the_platforms_contract() -> None:
    names = (
        "trial level t x y z roll pitch yaw u v w p q r current_x current_y current_z "
        "target_x target_y tracked_x tracked_y corner_0 corner_1 corner_2 corner_3 corner_4 "
        "corner_5 corner_6 corner_7 tracker_ok tracker_error error_x error_y error_z error_x_px "
        "error_y_px distance_px distance ref_u ref_v ref_w ref_r dvl_u dvl_v dvl_w thrust_0 "
        "thrust_1 thrust_2 thrust_3 thrust_4 thrust_5 thrust_6 thrust_7 contact_n step_us"
    )

    assert names.split() == list(NAMES)
    assert all(column.meaning for column in telemetry.COLUMNS)


@settings(max_examples=30)
@given(rows=finite_rows)
def test_csv_reads_back_as_the_same_bits(rows: Rows) -> None:
    text = telemetry.header(["a comment\nof two lines"], width=rows.shape[1])
    names, back = telemetry_csv.read(text + telemetry.csv_lines(rows))

    assert tuple(names) == telemetry.names(rows.shape[1])
    assert np.array_equal(back, rows)


def _python_text(rows: Rows) -> str:
    """Return rows as CSV by Python's own text of each float."""
    lines = ([repr(value).removesuffix(".0") for value in row] for row in rows.tolist())
    return "".join(",".join(line) + "\n" for line in lines)


@pytest.mark.slow
@pytest.mark.parametrize(
    "numbers",
    [
        np.random.default_rng(5).integers(0, 2**64, 50_000, np.uint64).view(np.float64),
        np.random.default_rng(6).standard_normal(50_000),
        np.random.default_rng(7).standard_normal(50_000).astype(np.float32).astype(np.float64),
        2.0 ** np.arange(-1074, 1024),
        np.nextafter(2.0 ** np.arange(-1074, 1024), 0.0),
        10.0 ** np.arange(-20, 20),
        np.nextafter(10.0 ** np.arange(-20, 20), 0.0),
        np.array([0.0, -0.0, 1.0, -1.0, 2.0**53, np.nan, np.inf, -np.inf, 9e15, 1e22]),
    ],
    ids="bits normal single powers-2 below-2 powers-10 below-10 special".split(),
)
def test_csv_has_the_bytes_of_pythons_shortest_text(numbers: Rows) -> None:
    for width in (1, 2):
        rows = numbers[: len(numbers) // width * width].reshape(-1, width)
        assert telemetry.csv_lines(rows) == _python_text(rows)
        assert telemetry.csv_lines(-rows) == _python_text(-rows)


def test_csv_begins_with_comments_and_the_header_row() -> None:
    lines = telemetry.header(["seed 5"]).splitlines()

    assert lines[0] == "# seed 5"
    assert lines[1].startswith("trial,level,t,x,y,z,")
    assert len(lines) == 2


@settings(max_examples=30)
@given(rows=finite_rows)
def test_rows_of_any_width_survive_a_message(rows: Rows) -> None:
    assert np.array_equal(telemetry.from_bytes(telemetry.to_bytes(rows)), rows)


@pytest.mark.parametrize("thrusters", [0, 1, COMMON_THRUSTERS, COMMON_THRUSTERS + 4])
def test_every_thruster_has_a_column_and_none_of_the_others_moves(thrusters: int) -> None:
    width = telemetry.width_for(thrusters)

    names = telemetry.names(width)

    assert len(names) == len(set(names)) == width
    assert names[:WIDTH] == NAMES
    assert set(telemetry.thrust_names(thrusters)) <= set(names)


def test_the_width_of_rows_says_which_columns_they_have() -> None:
    alone = [(False, False, False, route, False) for route in (False, True)]
    arms = [
        (True, work, search, False, False)
        for work, search in ((False, False), (True, False), (True, True))
    ]
    kinds = [
        (thrusters, *groups, detections)
        for thrusters, groups, detections in product(
            range(COMMON_THRUSTERS, THRUSTERS_MAX + 1), [*alone, *arms], [False, True]
        )
    ]
    # A dock's rows have a column for every thruster that a vehicle may have.
    kinds += [(THRUSTERS_MAX, *[False] * 4, True, detections) for detections in (False, True)]
    groups = "arm", "work", "search", "route", "dock", "detections"

    widths = [
        telemetry.width_for(thrusters, **dict(zip(groups, flags, strict=True)))
        for thrusters, *flags in kinds
    ]

    assert len(set(widths)) == len(widths)
    for kind, width in zip(kinds, widths, strict=True):
        names = telemetry.names(width)
        found = sum(name.startswith("thrust_") for name in names)
        has = [getattr(telemetry, f"has_{group}")(width) for group in groups]
        assert (found, *has) == kind
        assert len(set(names)) == len(names) == width


def test_rows_of_a_dock_are_as_wide_whatever_the_vehicle() -> None:
    assert telemetry.DOCK_THRUSTERS == THRUSTERS_MAX
    widths = {telemetry.width_for(count, dock=True) for count in range(THRUSTERS_MAX + 1)}
    assert len(widths) == 1


@pytest.mark.parametrize(("arm", "work"), [(False, False), (True, False), (True, True)])
@pytest.mark.parametrize("thrusters", [COMMON_THRUSTERS, COMMON_THRUSTERS + 2, THRUSTERS_MAX])
def test_detections_are_the_columns_with_their_names(arm: bool, work: bool, thrusters: int) -> None:
    rows = np.zeros((2, telemetry.width_for(thrusters, arm=arm, work=work, detections=True)))
    telemetry.detections(rows)[:] = 1.0
    telemetry.detections(rows[1])[:] = 2.0

    filled = [
        name for name, row in zip(telemetry.names(rows.shape[1]), rows.T, strict=True) if row.any()
    ]
    assert filled == [column.name for column in telemetry.DETECTION_COLUMNS]
    assert set(rows[1]) == {0.0, 2.0}


def test_rows_of_a_detector_have_an_object_of_each_class_and_sixteen_answers() -> None:
    names = [column.name for column in telemetry.DETECTION_COLUMNS]
    corners = ["x0", "y0", "x1", "y1", "x2", "y2", "x3", "y3"]

    objects = ["state", *corners, "visible", "distance", "angle"]
    answers = ["label", "confidence", *corners, "outcome", "iou", "error", "on"]
    assert names == [
        *(f"object_{index}_{name}" for index in range(8) for name in objects),
        *(f"answer_{index}_{name}" for index in range(16) for name in answers),
    ]


@pytest.mark.parametrize("thrusters", [COMMON_THRUSTERS, COMMON_THRUSTERS + 2])
def test_the_thrusts_of_rows_are_their_thrust_columns_in_order(thrusters: int) -> None:
    rows = numbered(3, telemetry.width_for(thrusters))
    index = {name: at for at, name in enumerate(telemetry.names(rows.shape[1]))}

    expected = rows[:, [index[name] for name in telemetry.thrust_names(thrusters)]]

    assert np.array_equal(telemetry.thrusts(rows), expected)


def test_the_digest_does_not_depend_on_how_rows_are_cut() -> None:
    rows, pieces = numbered(10), Digest()

    for start, end in ((0, 1), (1, 7), (7, 10)):
        pieces.add(rows[start:end])

    assert pieces.hexdigest() == telemetry.digest(rows)


def test_the_digest_leaves_out_the_wall_time_and_nothing_else() -> None:
    rows, slower = numbered(4), numbered(4)
    slower[2, INDEX["step_us"]] += 1.0

    assert telemetry.digest(slower) == telemetry.digest(rows)
    for name in set(NAMES) - {"step_us"}:
        changed = numbered(4)
        changed[2, INDEX[name]] += 1.0
        assert telemetry.digest(changed) != telemetry.digest(rows), name


def test_a_row_that_was_not_committed_is_not_delivered() -> None:
    delivered: list[Rows] = []
    recorder = Recorder(delivered.append, width=telemetry.width_for(5))
    recorder.next_row()[:] = 1.0
    recorder.commit()
    recorder.next_row()[:] = 2.0

    recorder.flush()
    recorder.flush()

    assert [rows[:, 0].tolist() for rows in delivered] == [[1.0]]


def test_a_full_buffer_is_delivered_at_once_as_a_copy() -> None:
    delivered: list[Rows] = []
    recorder = Recorder(delivered.append, width=telemetry.width_for(10))

    for number in range(DELIVERED_ROWS + 1):
        recorder.next_row()[:] = number
        recorder.commit()

    assert [rows.shape for rows in delivered] == [(DELIVERED_ROWS, WIDTH + 2)]
    assert delivered[0][:, 0].tolist() == list(range(DELIVERED_ROWS))

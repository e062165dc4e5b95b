"""Telemetry reads back as it was written, whole or in part."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import INDEX, NAMES, WIDTH, Digest, Recorder, Rows

finite_rows = arrays(
    np.float64,
    st.tuples(st.integers(0, 3), st.just(WIDTH)),
    elements=st.floats(allow_nan=False, allow_infinity=False),
    fill=st.just(0.0),
)


def numbered(count: int) -> Rows:
    return np.arange(count * WIDTH, dtype=np.float64).reshape(count, WIDTH) / 7.0


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
    back = telemetry.from_csv(telemetry.to_csv(rows, ["a comment\nof two lines"]))

    assert np.array_equal(back, rows)


def test_csv_begins_with_comments_and_the_header_row() -> None:
    lines = telemetry.to_csv(numbered(1), ["seed 5"]).splitlines()

    assert lines[0] == "# seed 5"
    assert lines[1].startswith("trial,level,t,x,y,z,")
    assert len(lines) == 3


def test_csv_in_pieces_is_the_same_document() -> None:
    rows = numbered(10)

    assert "".join(telemetry.csv_chunks(rows, ["x"], size=3)) == telemetry.to_csv(rows, ["x"])


def test_a_csv_of_other_columns_is_refused() -> None:
    with pytest.raises(ValueError, match="columns of this version"):
        telemetry.from_csv("a,b\n1,2\n")


def test_half_a_row_at_the_end_of_a_file_is_left_out() -> None:
    data = numbered(3).astype("<f8").tobytes()

    assert np.array_equal(telemetry.from_bytes(data[:-5]), numbered(2))


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


def test_a_row_that_was_not_kept_is_not_delivered() -> None:
    recorder = Recorder(3)
    recorder.next_row()[:] = 1.0
    recorder.keep()
    recorder.next_row()[:] = 2.0

    assert recorder.take()[:, 0].tolist() == [1.0]
    assert len(recorder.take()) == 0

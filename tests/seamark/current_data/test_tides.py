"""Tidal constituents give the series that utide's own analysis finds them in."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
import utide

from seamark.current_data.series import CurrentRefused, record_of
from seamark.current_data.tides import Constituent, predicted, read_constituents

BEGIN = datetime(2024, 3, 1, tzinfo=UTC)
CONSTITUENTS = [
    Constituent("M2", 0.5, 70.0, 0.05, 340.0, 65.0),
    Constituent("S2", 0.2, 100.0, 0.0, 0.0, 65.0),
    Constituent("K1", 0.1, 200.0, 0.02, 110.0, 40.0),
]


@pytest.mark.slow
def test_utide_finds_the_constituents_again_in_the_series() -> None:
    series = predicted(
        CONSTITUENTS, begin=BEGIN, hours=24.0 * 40.0, latitude_deg=43.0, height_m=2.0, step_s=3600.0
    )
    north, east, _down = series.velocity[0]
    dates = np.array(
        [(BEGIN + timedelta(seconds=t)).replace(tzinfo=None) for t in series.times.tolist()],
        dtype="datetime64[s]",
    )

    found = utide.solve(
        dates,
        east,
        north,
        lat=43.0,
        constit=["M2", "S2", "K1"],
        conf_int="none",
        trend=False,
        verbose=False,
    )

    major = dict(zip(found.name.tolist(), found.Lsmaj.tolist(), strict=True))
    assert major == pytest.approx({"M2": 0.5, "S2": 0.2, "K1": 0.1}, rel=0.01)
    again = utide.reconstruct(dates, found, verbose=False)
    assert again.u == pytest.approx(east, abs=0.005)
    assert again.v == pytest.approx(north, abs=0.005)


def test_a_mean_along_an_azimuth_flows_there_and_nothing_else_happens() -> None:
    series = predicted(
        [Constituent("Z0", 0.3, 0.0, 0.0, 0.0, 90.0)],
        begin=BEGIN,
        hours=6.0,
        latitude_deg=43.0,
        height_m=2.0,
    )

    record = record_of(series).record

    assert record.velocity[0, 1] == pytest.approx(0.3)
    assert record.velocity[0, 0] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("", "first line must be"),
        ("name,major_m_s\nM2,1\n", "first line must be"),
        ("HEAD\n", "1 to 150 constituents"),
        ("HEAD\nM2,1,2\n", "five numbers"),
        ("HEAD\nM2,inf,0,0,0,0\n", "five numbers"),
        ("HEAD\n" + "M2,1,0,0,0,0\n" * 200, "1 to 150 constituents"),
        ("x" * 200_000, "at most 100000 bytes"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path: Path, content: str, sentence: str) -> None:
    path = tmp_path / "tide.csv"
    head = "name,major_m_s,major_phase_deg,minor_m_s,minor_phase_deg,azimuth_deg"
    path.write_text(content.replace("HEAD", head))

    with pytest.raises(CurrentRefused, match=sentence):
        read_constituents(path)


def test_an_unknown_constituent_is_named() -> None:
    with pytest.raises(CurrentRefused, match="does not know the constituent X9"):
        predicted(
            [Constituent("X9", 1.0, 0.0, 0.0, 0.0, 0.0)],
            begin=BEGIN,
            hours=1.0,
            latitude_deg=43.0,
            height_m=1.0,
        )

"""How long trackers last: the cases are the benchmark's, the page says what they show."""

from pathlib import Path
from typing import Any

import pytest

from performance.visibility.cases import GROUPS, IN_PLANE, STEP
from performance.visibility.page import write
from seamark.sim.registry import benchmark
from seamark.sim.settings.configuration import ConfigurationInvalid
from seamark.sim.trackers.visp import why_not

VISIBILITY = benchmark("visibility-v1")


def _measured(label: str, scores: list[float]) -> dict[str, Any]:
    overall = {"p5_percent": 70.0, "p1_percent": 60.0, "corner_px": None}
    return {
        "label": label,
        "scores": scores,
        "overall": overall | {"not_admitted_percent": 0.1},
        "p5": [100.0, 20.0],
    }


@pytest.mark.parametrize("group", GROUPS)
def test_every_case_is_one_that_the_benchmark_takes(group: str) -> None:
    for case in GROUPS[group]:
        settings = {"sweep_step": STEP, "level_duration_s": case.level_s, **case.config}
        try:
            VISIBILITY.read(settings)
        except ConfigurationInvalid as refusal:
            assert why_not(), (case.label, refusal.errors)  # noqa: PT017  # ViSP is not here


def test_no_two_cases_of_a_group_have_one_name() -> None:
    for cases in GROUPS.values():
        assert len({case.label for case in cases}) == len(cases)


def test_a_path_in_the_plane_neither_turns_nor_rises() -> None:
    config = VISIBILITY.read(IN_PLANE)
    level: Any = VISIBILITY.load().level(config, None, seed=1, trial=0, level=0)

    first, later = (level._path.at(t)[0] for t in (0.0, 1.3))

    assert first[:2] != later[:2]
    assert first[2:] == later[2:]


def test_the_page_says_whether_fewer_degrees_of_freedom_last_longer(tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    scores = {"translation": 5.5, "rt": 5.5, "srt": 5.4, "affine": 5.6, "homography": 5.0}
    kept = {"in-plane": [_measured(f"ssd {warp}", [at, at]) for warp, at in scores.items()]}
    kept["visp"] = [_measured("visp ssd ic homography", [3.0, 3.5, 3.0])]

    write(kept, tmp_path)
    text = (tmp_path / "visibility.md").read_text(encoding="utf-8")

    assert "SSD: fewer degrees of freedom last longer, but not at every step." in text
    assert "+0.50 beside the homography" in text
    assert "their levels last 2 s" in text

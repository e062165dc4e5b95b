"""The visibility page: its cases are valid and its sentences follow from the results."""

from pathlib import Path
from typing import Any

import pytest

from performance.perception.visibility.cases import GROUPS, IN_PLANE, STEP
from performance.perception.visibility.page import write
from seamark.sim.registry import benchmark
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.trackers.visp.installation import unavailable_reason

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
def test_the_benchmark_accepts_every_case(group: str) -> None:
    for case in GROUPS[group]:
        settings = {"sweep_step": STEP, "level_duration_s": case.level_s, **case.config}
        try:
            VISIBILITY.read(settings)
        except ConfigurationInvalid as refusal:
            assert unavailable_reason(), (case.label, refusal.errors)  # noqa: PT017  # ViSP is not here


def test_the_cases_of_a_group_have_different_names() -> None:
    for cases in GROUPS.values():
        assert len({case.label for case in cases}) == len(cases)


def test_a_path_in_the_plane_neither_turns_nor_rises() -> None:
    config = VISIBILITY.read(IN_PLANE)
    level: Any = VISIBILITY.load().level(config, None, seed=1, trial=0, level=0)

    first, later = (level._path.pose_and_velocity(t)[0] for t in (0.0, 1.3))

    assert first[:2] != later[:2]
    assert first[2:] == later[2:]


@pytest.mark.slow
def test_the_page_says_whether_fewer_degrees_of_freedom_raise_the_score(tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    scores = {"translation": 5.5, "rt": 5.5, "srt": 5.4, "affine": 5.6, "homography": 5.0}
    kept = {"in-plane": [_measured(f"ssd {warp}", [at, at]) for warp, at in scores.items()]}
    kept["visp"] = [_measured("visp ssd ic homography", [3.0, 3.5, 3.0])]

    write(kept, tmp_path)
    text = (tmp_path / "visibility.md").read_text(encoding="utf-8")

    assert "SSD: τ50 increases with fewer degrees of freedom, but not at every step." in text
    assert "differs from the homography by +0.50" in text
    assert "their levels last\n2 s" in text

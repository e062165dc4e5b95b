"""What the terminal shows of a run."""

from typing import Any

from seamark.cli.run_summary import summary

RUN: dict[str, Any] = {"state": "succeeded", "result": {"score": 0.5}, "metrics": {}}
PARTS = {
    "reference": {"score": 0.9, "score_low": 0.8, "score_high": 1.0},
    "gap": {"value": 0.4, "low": 0.3, "high": 0.5},
}


def test_a_run_on_fresh_water_has_its_reference_score_and_gap() -> None:
    lines = summary(RUN | {"metrics": PARTS}).splitlines()

    assert lines == [
        "Score 0.5",
        "Reference score 0.9 (95 % interval 0.8 to 1)",
        "Generalisation gap 0.4 (95 % interval 0.3 to 0.5)",
    ]


def test_a_run_that_does_not_rank_says_why() -> None:
    assert summary(RUN | {"not_ranked": "It drove away."}).endswith("Not ranked. It drove away.")


def test_a_run_without_parts_shows_its_score_alone() -> None:
    assert summary(RUN) == "Score 0.5"


def test_the_levels_of_an_arm_have_their_credit_and_what_it_cost() -> None:
    level = {
        "level": 0,
        "speed": 0.1,
        "credit": 0.6,
        "time_s": 90.0,
        "push_n": 72.99,
        "hull_n": 0.0,
    }
    table = summary(RUN | {"metrics": {"levels": [level]}}).splitlines()[1:]

    assert [line.split() for line in table] == [
        ["level", "speed", "credit", "time_s", "push_n", "hull_n"],
        ["0", "0.1", "0.6", "90", "72.99", "0"],
    ]

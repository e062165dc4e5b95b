"""What the check of a draft says: each sentence appears when it is true, and only then."""

from dataclasses import replace

import pytest

from seamark.competitions.check_report import HOUR_S, Draft, Reference, report
from seamark.competitions.findings import Finding, Level

SPREAD = (0.02, -0.03, 0.01, 0.0, -0.01, 0.03, -0.02, 0.0)
DRAFT = Draft(trials=8, block=1, paired=False, slots=2)


def reference(
    name: str, score: float, *, is_bound: bool = False, wall_s: float = 60.0
) -> Reference:
    scores = [score + each for each in SPREAD]
    return Reference(name=name, title=name.upper(), is_bound=is_bound, scores=scores, wall_s=wall_s)


NOTHING = reference("nothing", 0.0, is_bound=True)
BLIND = reference("blind", 0.1, is_bound=True)
ORACLE = reference("oracle", 1.0, is_bound=True)
GOOD = [NOTHING, BLIND, reference("p", 0.4), reference("lqr", 0.6), ORACLE]


def level_of(findings: list[Finding], word: str) -> Level:
    """Return the level of the only sentence with a word."""
    (level,) = {finding.level for finding in findings if word in finding.sentence}
    return level


def test_a_sound_draft_has_only_good_findings() -> None:
    findings = report(GOOD, replace(DRAFT, teams=10, quota=6, qualification_s=100 * HOUR_S))

    assert [finding.sentence for finding in findings if finding.level != Level.GOOD] == []
    assert [finding.sentence for finding in findings] == [
        "8 trials tell 4 of 4 pairs of neighbouring reference entries apart (each on trials of its "
        "own, 95 % confidence for each pair).",
        "“LQR” gets 60 % of the way from doing nothing (0) to the oracle (1), which leaves room "
        "for better programs.",
        "“BLIND”, which does not look, gets 10 % of the way from doing nothing (0) to the oracle "
        "(1): the task needs its sensors.",
        "A run takes 60 s, at most 60 s (“NOTHING”); an uploaded program may take longer, up to "
        "its limit.",
        "10 teams with 6 submissions each take 30 minutes on 2 slots, 0.5 % of the 4.17 days of "
        "the qualification.",
    ]


@pytest.mark.parametrize(
    ("scores", "level"),
    [((0.4, 0.6), Level.GOOD), ((0.400, 0.401), Level.WARNING), ((0.000, 0.001), Level.PROBLEM)],
)
def test_neighbours_that_are_alike_are_counted(scores: tuple[float, float], level: Level) -> None:
    """Of three pairs none, one or two."""
    others = [reference(f"c{at}", score) for at, score in enumerate(scores)]

    findings = report([NOTHING, ORACLE, *others], DRAFT)

    assert level_of(findings, "pairs of neighbouring") == level


def test_pairs_on_the_same_trials_are_compared_trial_by_trial() -> None:
    """All have the same spread, so that their differences have none."""
    close = [*GOOD, reference("pi", 0.401), reference("mpc", 0.601)]

    own = report(close, DRAFT)
    same = report(close, replace(DRAFT, paired=True))

    assert "8 trials tell 4 of 6 pairs" in own[0].sentence
    assert "8 trials tell 6 of 6 pairs" in same[0].sentence


def test_the_number_of_trials_that_a_pair_needs_is_about_right() -> None:
    """A difference that is half of its margin needs four times as many trials."""
    pair = [reference("p", 0.400), reference("pi", 0.411)]

    sentence = report(pair, DRAFT)[0].sentence

    # Standard error of a difference sqrt(2 * 0.0004 / 8) = 0.01, and t = 2.14 of 14 degrees.
    assert "“PI” (0.411) and “P” (0.4) would need about 31 trials" in sentence
    apart = report([reference("p", 0.400), reference("pi", 0.422)], DRAFT)[0].sentence
    assert "1 of 1 pairs" in apart


def test_a_pair_that_differs_by_nothing_is_not_worth_more_trials() -> None:
    sentence = report([reference("p", 0.4), reference("pi", 0.4)], DRAFT)[0].sentence

    assert "can hardly be told apart at all" in sentence


def test_a_submission_of_one_block_has_no_interval() -> None:
    findings = report(GOOD, replace(DRAFT, block=8))

    assert level_of(findings, "no interval can be computed") == Level.PROBLEM
    assert "at least 16, better to 96" in findings[0].sentence


@pytest.mark.parametrize(
    ("best", "word", "level"),
    [
        (0.6, "leaves room", Level.GOOD),
        (0.9, "hardly any room", Level.WARNING),
        (0.97, "hardly any room", Level.PROBLEM),
        (0.03, "too hard", Level.WARNING),
    ],
)
def test_the_best_entry_that_is_no_bound_tells_how_hard_it_is(
    best: float, word: str, level: Level
) -> None:
    findings = report([NOTHING, BLIND, ORACLE, reference("lqr", best)], DRAFT)

    assert level_of(findings, word) == level


def test_most_trials_at_one_maximal_score_are_a_problem_for_entries_that_are_no_bound() -> None:
    full = replace(reference("lqr", 0.0), scores=[1.0] * 5 + [0.2] * 3)
    half = replace(reference("pi", 0.0), scores=[1.0] * 4 + [0.2] * 4)
    oracle = replace(ORACLE, scores=[1.0] * 8)

    findings = report([NOTHING, full, half, oracle], DRAFT)

    said = [finding for finding in findings if "could not show it" in finding.sentence]
    assert [finding.level for finding in said] == [Level.PROBLEM]
    assert "“LQR” has the same score, 1, in 5 of 8 trials" in said[0].sentence


def test_a_scenario_in_which_all_have_the_same_score_measures_nothing() -> None:
    flat = [replace(each, scores=[0.0] * 8) for each in GOOD]

    findings = report(flat, DRAFT)

    assert level_of(findings, "measures nothing") == Level.PROBLEM
    assert level_of(findings, "no better than doing nothing") == Level.PROBLEM


@pytest.mark.parametrize(
    ("score", "level"), [(0.1, Level.GOOD), (0.3, Level.WARNING), (0.6, Level.PROBLEM)]
)
def test_a_blind_entry_that_gets_far_is_said(score: float, level: Level) -> None:
    findings = report([NOTHING, reference("blind", score, is_bound=True), ORACLE], DRAFT)

    assert level_of(findings, "does not look") == level


@pytest.mark.parametrize("missing", [NOTHING, ORACLE])
def test_what_cannot_be_told_without_a_bound_is_said(missing: Reference) -> None:
    findings = report([each for each in GOOD if each != missing], DRAFT)

    assert level_of(findings, "How much room the scenario leaves is unknown") == Level.WARNING
    assert level_of(findings, "without looking is unknown") == Level.WARNING


@pytest.mark.parametrize(
    ("hours", "level"),
    [(None, Level.GOOD), (24, Level.GOOD), (9, Level.WARNING), (4, Level.PROBLEM)],
)
def test_a_qualification_needs_enough_slots(hours: int | None, level: Level) -> None:
    """Ten teams with 60 runs of a minute each: five hours on two slots."""
    open_s = None if hours is None else hours * HOUR_S

    findings = report(GOOD, replace(DRAFT, teams=10, quota=60, qualification_s=open_s))

    assert level_of(findings, "10 teams with 60 submissions each take 5 hours on 2 slots") == level


def test_long_runs_are_said() -> None:
    findings = report([*GOOD, reference("mpc", 0.8, wall_s=7200.0)], DRAFT)

    assert level_of(findings, "A run takes 60 s, at most 2 hours (“MPC”)") == Level.WARNING


def test_a_reference_that_failed_is_a_problem_and_the_others_are_compared() -> None:
    failed = replace(GOOD[2], scores=None, failed_why="it needs an arm.")

    findings = report([*GOOD[:2], failed, *GOOD[3:]], DRAFT)

    assert level_of(findings, "“P” failed: it needs an arm. Change") == Level.PROBLEM
    assert "3 of 3 pairs" in findings[1].sentence


@pytest.mark.parametrize("references", [[], [replace(NOTHING, scores=None)]])
def test_without_any_result_that_is_the_problem(references: list[Reference]) -> None:
    findings = report(references, DRAFT)

    assert {finding.level for finding in findings} == {Level.PROBLEM}
    assert findings[-1].sentence.startswith("No reference entry has a result")


@pytest.mark.parametrize(
    ("draft", "word"),
    [
        (replace(DRAFT, slots=0), "slot"),
        (replace(DRAFT, trials=6), "8 trials instead of 6"),
        (replace(DRAFT, block=3), "complete blocks"),
    ],
)
def test_runs_that_do_not_fit_the_draft_are_an_error(draft: Draft, word: str) -> None:
    with pytest.raises(ValueError, match=word):
        report(GOOD, draft)

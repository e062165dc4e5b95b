"""What an organiser should know of a draft before it opens, from the runs of its references.

Every sentence has the figures that it is drawn from, and says what to do. The thresholds are
estimates (E): in the benchmarks of this service blind entries get 8 to 18 % of the way from doing
nothing to the oracle, and the best entries that are no bounds 47 to 85 % (docs/headroom.json).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from seamark.competitions.findings import Finding, Level
from seamark.sim.numerics.statistics import difference_interval, mean, paired_interval, percentile

APART_GOOD, APART_WARNING = 0.75, 0.4  # E: share of neighbouring pairs that are told apart
BLIND_PROBLEM, BLIND_WARNING = 0.5, 0.25  # E: of the way from nothing to the oracle
BEST_PROBLEM, BEST_WARNING = 0.95, 0.85  # E: the same, of an entry that is no bound
TOO_HARD = 0.05  # E: the same, of the best entry that is no bound
AT_MAXIMUM = 0.5  # E: share of an entry's trials
LONG_RUN_S = 1800.0  # E: nobody waits longer for a result while they look at it
BUSY_PROBLEM, BUSY_WARNING = 1.0, 0.5  # E: of a round's time; many teams submit on its last day
NOTHING, BLIND, ORACLE = "nothing", "blind", "oracle"
TRIALS_MAX = 1000  # E: more is not worth waiting for
HOUR_S = 3600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Reference:
    """A reference entry and how its run ended."""

    name: str  # of the built-in solution
    title: str
    is_bound: bool  # no solution that a team may use: doing nothing, blind, the oracle
    scores: Sequence[float] | None  # of each trial, in their order; None: it failed
    failed_why: str = ""
    wall_s: float = 0.0  # how long its run took

    @property
    def score(self) -> float:
        """The mean over its trials; nan if it failed."""
        return mean(self.scores or ())


@dataclass(frozen=True, slots=True, kw_only=True)
class Draft:
    """What decides whether the references can be told apart, and how long it all takes.

    All runs of the references have `trials` trials. `paired` says that these had the same seeds.
    """

    trials: int
    block: int  # RankedProtocol.block
    paired: bool
    slots: int  # runs that the workers evaluate at the same time
    teams: int | None = None  # how many are expected; None: unknown
    quota: int | None = None  # submissions of a team in the whole qualification
    qualification_s: float | None = None  # how long it is open


def report(references: Sequence[Reference], draft: Draft) -> list[Finding]:
    """Return the findings, subject by subject.

    Raises
    ------
    ValueError
        If a reference has another number of trials than the draft says, if these are no complete
        blocks, or if there is no slot.
    """
    if draft.slots < 1:
        raise ValueError(f"there must be at least one slot, not {draft.slots}")
    if draft.trials < 1 or draft.block < 1 or draft.trials % draft.block:
        raise ValueError(f"{draft.trials} trials are not complete blocks of {draft.block}")
    ran = [each for each in references if each.scores is not None]
    for each in ran:
        if len(each.scores or ()) != draft.trials:
            raise ValueError(
                f"{each.name} has {len(each.scores or ())} trials instead of {draft.trials}"
            )
    return [
        *_failures(references),
        *_separation(ran, draft),
        *_difficulty(ran),
        *_saturation(ran),
        *_blindness(ran),
        *_duration(ran, draft),
    ]


def _failures(references: Sequence[Reference]) -> Iterator[Finding]:
    for each in references:
        if each.scores is None:
            why = each.failed_why.rstrip(".") or "no reason is known"
            yield Finding(
                Level.PROBLEM,
                f"The reference entry “{each.title}” failed: {why}. Change the scenario so that it "
                "runs, or leave the entry out.",
            )
    if all(each.scores is None for each in references):
        yield Finding(
            Level.PROBLEM,
            "No reference entry has a result, so nothing can be said about the scenario. Run the "
            "references again.",
        )


def _separation(ran: Sequence[Reference], draft: Draft) -> Iterator[Finding]:
    """How many of the neighbours in order of score the trials of one submission tell apart."""
    if len(ran) < 2:
        return
    if draft.trials < 2 * draft.block:
        yield Finding(
            Level.PROBLEM,
            f"A submission has {draft.trials} {_plural(draft.trials, 'trial')}, of which no "
            f"interval can be computed. Raise the trials to at least {2 * draft.block}, better to "
            f"{12 * draft.block}.",
        )
        return
    ordered = sorted(ran, key=lambda each: (-each.score, each.name))
    alike = [pair for pair in pairwise(ordered) if not _is_apart(_interval(*pair, draft))]
    pairs = len(ordered) - 1
    share = 1.0 - len(alike) / pairs
    how = "on the same trials" if draft.paired else "each on trials of its own"
    sentence = (
        f"{draft.trials} trials tell {pairs - len(alike)} of {pairs} pairs of neighbouring "
        f"reference entries apart ({how}, 95 % confidence for each pair)."
    )
    if alike:
        sentence += f" {_closest(alike, draft)}"
    yield Finding(_level(-share, warning=-APART_GOOD, problem=-APART_WARNING), sentence)


def _closest(alike: Sequence[tuple[Reference, Reference]], draft: Draft) -> str:
    """Return a sentence about the pair that needs fewest trials more, and what to do."""
    needed, first, second = min(
        ((_trials_needed(pair, draft), *pair) for pair in alike), key=lambda case: case[0]
    )
    which = f"“{first.title}” ({first.score:.3g}) and “{second.title}” ({second.score:.3g})"
    if needed > TRIALS_MAX:
        return f"{which} can hardly be told apart at all: the scenario treats them alike."
    return (
        f"{which} would need about {needed} trials: raise the trials of a submission, or leave it "
        "to the final, which adds batches until its ranks separate."
    )


def _trials_needed(pair: tuple[Reference, Reference], draft: Draft) -> int:
    """Return how many trials would probably tell two entries apart, in complete blocks."""
    low, high = _interval(*pair, draft)
    difference, margin = abs(0.5 * (low + high)), 0.5 * (high - low)
    if difference * math.sqrt(TRIALS_MAX) <= margin:
        return TRIALS_MAX + 1
    blocks = draft.trials / draft.block * (margin / difference) ** 2
    return draft.block * math.ceil(blocks)


def _interval(first: Reference, second: Reference, draft: Draft) -> tuple[float, float]:
    compare = paired_interval if draft.paired else difference_interval
    found = compare(first.scores or (), second.scores or (), block=draft.block)
    return found if found is not None else (-math.inf, math.inf)


def _is_apart(interval: tuple[float, float]) -> bool:
    low, high = interval
    return low > 0.0 or high < 0.0


def _difficulty(ran: Sequence[Reference]) -> Iterator[Finding]:
    """Whether the best entry that is no bound gets anywhere, and leaves room above."""
    way = _way(ran)
    solutions = [each for each in ran if not each.is_bound]
    if way is None or not solutions:
        if ran:
            yield Finding(
                Level.WARNING,
                "How much room the scenario leaves is unknown: that takes results of doing "
                "nothing, of the oracle, and of one entry that is no bound. Add them.",
            )
        return
    nothing, oracle = way
    if oracle <= nothing:
        yield Finding(
            Level.PROBLEM,
            f"The oracle ({oracle:.3g}) is no better than doing nothing ({nothing:.3g}): no "
            "program can do well. Lower the levels.",
        )
        return
    best = max(solutions, key=lambda each: each.score)
    share = (best.score - nothing) / (oracle - nothing)
    says = (
        f"“{best.title}” gets {_percent(share)} of the way from doing nothing "
        f"({nothing:.3g}) to the oracle ({oracle:.3g})"
    )
    level = _level(share, warning=BEST_WARNING, problem=BEST_PROBLEM)
    if share < TOO_HARD:
        yield Finding(
            Level.WARNING,
            f"{says}: it is too hard for what exists. Lower the levels, or help more.",
        )
    elif level == Level.GOOD:
        yield Finding(level, f"{says}, which leaves room for better programs.")
    else:
        yield Finding(
            level,
            f"{says}, which leaves hardly any room for better programs. Raise the levels, such as "
            "those of the current, or make the vehicle or its sensors worse.",
        )


def _saturation(ran: Sequence[Reference]) -> Iterator[Finding]:
    """Entries most of whose trials have the best score that anything gets."""
    scores = [score for each in ran for score in each.scores or ()]
    if not scores:
        return
    maximum = max(scores)
    if maximum == min(scores):
        yield Finding(
            Level.PROBLEM,
            f"All trials of all reference entries have the same score, {maximum:.3g}: the scenario "
            "measures nothing. Change its levels.",
        )
        return
    for each in ran:
        at_maximum = sum(score == maximum for score in each.scores or ())
        if not each.is_bound and at_maximum > AT_MAXIMUM * len(each.scores or ()):
            yield Finding(
                Level.PROBLEM,
                f"“{each.title}” has the same score, {maximum:.3g}, in {at_maximum} of "
                f"{len(each.scores or ())} trials, and nothing has a higher one: better programs "
                "could not show it. Raise the highest level.",
            )


def _blindness(ran: Sequence[Reference]) -> Iterator[Finding]:
    """What an entry gets that does not look."""
    way = _way(ran)
    blind = [each for each in ran if each.name == BLIND]
    if way is None or not blind:
        if ran:
            yield Finding(
                Level.WARNING,
                "Whether the task can be done without looking is unknown: that takes results of "
                "a blind entry, of doing nothing and of the oracle. Submit a program that ignores "
                "its sensors, and compare.",
            )
        return
    nothing, oracle = way
    if oracle <= nothing:  # the difficulty says so
        return
    share = (blind[0].score - nothing) / (oracle - nothing)
    level = _level(share, warning=BLIND_WARNING, problem=BLIND_PROBLEM)
    says = (
        f"“{blind[0].title}”, which does not look, gets {_percent(share)} of the way from "
        f"doing nothing ({nothing:.3g}) to the oracle ({oracle:.3g})"
    )
    if level == Level.GOOD:
        yield Finding(level, f"{says}: the task needs its sensors.")
    else:
        yield Finding(
            level,
            f"{says}: much of the score needs no sensor. Raise the levels, or lengthen the trials, "
            "so that a program has to look.",
        )


def _duration(ran: Sequence[Reference], draft: Draft) -> Iterator[Finding]:
    """How long a run takes, and all of the qualification."""
    if not ran:
        return
    typical = percentile([each.wall_s for each in ran], 0.5)
    longest = max(ran, key=lambda each: each.wall_s)
    says = (
        f"A run takes {_time(typical)}, at most {_time(longest.wall_s)} (“{longest.title}”); an "
        "uploaded program may take longer, up to its limit."
    )
    if longest.wall_s > LONG_RUN_S:
        yield Finding(Level.WARNING, f"{says} Lower the trials or the duration of the levels.")
    else:
        yield Finding(Level.GOOD, says)
    if draft.teams is None or draft.quota is None:
        return
    total = draft.teams * draft.quota * typical / draft.slots
    says = (
        f"{draft.teams} {_plural(draft.teams, 'team')} with {draft.quota} "
        f"{_plural(draft.quota, 'submission')} each take {_time(total)} on {draft.slots} "
        f"{_plural(draft.slots, 'slot')}"
    )
    if draft.qualification_s is None:
        yield Finding(
            Level.GOOD, f"{says}. Keep the qualification open for at least twice as long."
        )
        return
    share = total / draft.qualification_s
    level = _level(share, warning=BUSY_WARNING, problem=BUSY_PROBLEM)
    says += f", {_percent(share)} of the {_time(draft.qualification_s)} of the qualification."
    if level != Level.GOOD:
        says += " Add workers, lower the quota or the trials, or keep it open for longer."
    yield Finding(level, says)


def _way(ran: Sequence[Reference]) -> tuple[float, float] | None:
    """Return the scores of doing nothing and of the oracle; None unless both ran."""
    scores = {each.name: each.score for each in ran}
    nothing, oracle = scores.get(NOTHING), scores.get(ORACLE)
    if nothing is None or oracle is None:
        return None
    return nothing, oracle


def _level(value: float, *, warning: float, problem: float) -> Level:
    """Return how bad a value is of which higher ones are worse."""
    if value > problem:
        return Level.PROBLEM
    return Level.WARNING if value > warning else Level.GOOD


def _time(seconds: float) -> str:
    for name, size in (("days", 48.0 * HOUR_S), ("hours", 2.0 * HOUR_S), ("minutes", 120.0)):
        if seconds >= size:
            units = {"days": 24.0 * HOUR_S, "hours": HOUR_S, "minutes": 60.0}
            return f"{seconds / units[name]:.3g} {name}"
    return f"{seconds:.0f} s"


def _plural(count: int, noun: str) -> str:
    return noun if count == 1 else f"{noun}s"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if abs(share) < 1.0 else f"{100.0 * share:.0f} %"

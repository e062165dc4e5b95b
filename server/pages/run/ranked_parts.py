"""The two parts of a ranked run as its page shows them: reference trials and fresh trials."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

HIGHER = (
    "Its 95 % interval lies above 0: this solution does better on the public reference trials "
    "than on trials it has not seen before."
)
LOWER = (
    "Its 95 % interval lies below 0: the public reference trials were harder than the fresh ones."
)
NONE = (
    "Its 95 % interval contains 0: nothing shows that this solution does better on trials it "
    "may have seen before."
)


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with its interval; without one `low` and `high` are None."""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True, slots=True)
class RankedParts:
    """The score of the reference trials, and how much it is above that of the fresh ones."""

    reference: Estimate
    gap: Estimate
    sentence: str  # what the gap says


def ranked_parts(metrics: Mapping[str, Any]) -> RankedParts | None:
    """Return the parts of a run; None for a run without them."""
    reference, gap = metrics.get("reference") or {}, metrics.get("gap") or {}
    if reference.get("score") is None or gap.get("value") is None:
        return None
    known = Estimate(reference["score"], reference.get("score_low"), reference.get("score_high"))
    difference = Estimate(gap["value"], gap.get("low"), gap.get("high"))
    return RankedParts(known, difference, _sentence(difference))


def _sentence(gap: Estimate) -> str:
    if gap.low is None or gap.high is None:
        return ""
    if gap.low > 0.0:
        return HIGHER
    return LOWER if gap.high < 0.0 else NONE

"""What pages say about the rules and the state of a competition, in sentences."""

from collections.abc import Mapping

from seamark.competitions.document import Programs, RoundKind
from seamark.competitions.standings import Ties
from seamark.server.competitions.competitions import CompetitionView, RoundView
from seamark.server.web.template_filters import ahead

PROGRAMS: Mapping[Programs, str] = {
    Programs.HIDDEN: "Nobody but your team may read the programs that you submit.",
    Programs.ORGANISER: "The organiser may read the programs that you submit, other teams may not.",
    Programs.PUBLIC: (
        "The organiser may read the programs that you submit. When the competition is decided, "
        "everybody may read those that decided it."
    ),
}
TIES: Mapping[Ties, str] = {
    Ties.EARLIER: "Equal scores are ordered by time: the earlier submission comes first.",
    Ties.SHARED: "Entries that the trials do not tell apart share a place.",
}
ROUND_KINDS: Mapping[RoundKind, str] = {
    RoundKind.PRACTICE: "Practice",
    RoundKind.QUALIFICATION: "Qualification",
    RoundKind.FINAL: "Final",
}


def round_state(one: RoundView) -> str:
    """Return what happens in a round now."""
    if one.decided_at is not None:
        return "decided"
    if one.accepts:
        return "open"
    return "being evaluated" if one.has_opened else "not open yet"


def state(competition: CompetitionView) -> str:
    """Return where a competition stands, as the end of a sentence."""
    if competition.ended_at is not None:
        return "decided"
    current, following = competition.current, competition.following
    if current is not None and current.closes_at is not None:
        return f"{ROUND_KINDS[current.kind].lower()} is open, closes {ahead(current.closes_at)}"
    waiting = [one for one in competition.rounds if one.has_opened and one.decided_at is None]
    if waiting:
        return f"{ROUND_KINDS[waiting[0].kind].lower()} is being evaluated"
    if following is not None:
        return f"{ROUND_KINDS[following.kind].lower()} opens {ahead(following.opens_at)}"
    return "being evaluated"

"""Checks the audit document of a competition: computes anew all that follows from the rest.

What nobody can compute from the document is that its commitments are those that were published
before the rounds, and that the service measured the scores that it says. The first anybody compares
who kept the commitments; the second anybody computes anew who has the program, since its seed is
here (`seamark run`).
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import isclose
from typing import Any

from seamark.competitions.audit_document import (
    Audit,
    AuditInvalid,
    Entry,
    Round,
    read,
)
from seamark.competitions.document import AnyRound, CompetitionDocument, Final, RoundKind, digest_of
from seamark.competitions.findings import Finding, Level
from seamark.competitions.keys import commitment, final_label, seed
from seamark.competitions.scores import summary
from seamark.competitions.standings import Finalist, Placing, Standings, Ties, decide
from seamark.sim import registry
from seamark.sim.numerics.ranking import Estimate, rank_ranges
from seamark.sim.numerics.statistics import mean
from seamark.sim.settings import own_files

# Pairs of finalists times trials that the standings of all batches take: some ten seconds. A final
# of 200 finalists with five batches of 24 trials has 7e6.
WORK_MAX = 1e8
FINALISTS_MAX = 2000
METHODS_MAX = 5000  # of a competition without a final
SHOWN = 10  # runs that a sentence names
_ROUNDING = 1e-9  # of scores: another program may add in another order


def verify(document: Mapping[str, Any]) -> list[Finding]:
    """Return what was checked and what is wrong.

    Raises
    ------
    AuditInvalid
        If the document cannot be read, or is too large to be checked.
    """
    audit = read(document)
    entries: dict[int, list[Entry]] = defaultdict(list)
    for entry in audit.entries:
        entries[entry.round].append(entry)
    findings = [_frozen(audit), *_plan(audit), *_files(audit)]
    has_final = any(each.kind == RoundKind.FINAL for each in audit.rounds)
    for each in audit.rounds:
        findings += _keys(audit, each, entries[each.number])
        findings += _runs(each, entries[each.number])
        if each.kind == RoundKind.FINAL:
            findings += _final(audit, each, entries[each.number])
        elif each.kind == RoundKind.QUALIFICATION and not has_final:
            findings.append(_board(audit, each, entries[each.number]))
    if audit.standings is not None and not has_final:
        findings.append(_problem("There are standings of a final, but no final."))
    if audit.board is not None and has_final:
        findings.append(_problem("There are places of a qualification, but the final decides."))
    return findings


def _frozen(audit: Audit) -> Finding:
    if digest_of(audit.frozen) != audit.frozen_sha256:
        return _problem("The frozen document does not have the SHA-256 that the audit states.")
    return _good(f"The frozen document has the SHA-256 {audit.frozen_sha256}.")


def _plan(audit: Audit) -> Iterator[Finding]:
    """Whether names, rounds and rules are those that were frozen."""
    try:
        frozen = CompetitionDocument.restore(audit.frozen)
        times = [_times(plan) for plan in frozen.rounds]
    except ValueError:  # also of pydantic
        yield _problem("The frozen document is none that this version of Seamark can read.")
        return
    differing = [
        name for name in ("title", "benchmark") if getattr(audit, name) != getattr(frozen, name)
    ]
    if audit.competition != frozen.name:
        differing.append("competition")
    if [each.number for each in audit.rounds] != [*range(1, 1 + len(frozen.rounds))]:
        yield _problem("The rounds are not those of the frozen document.")
        return
    for each, planned in zip(audit.rounds, times, strict=True):
        differing += [f"{name} of round {each.number}" for name in _differing(frozen, each)]
        yield from _moved(each, planned)
    if differing:
        yield _problem(f"Not as in the frozen document: {', '.join(differing)}.")
    else:
        yield _good("Names, rounds and rules are those of the frozen document.")


def _files(audit: Audit) -> Iterator[Finding]:
    """Whether the organiser's files are those that settings name by the start of their SHA-256."""
    settings = audit.frozen.get("settings")
    named = {
        name: value
        for name, value in (settings if isinstance(settings, dict) else {}).items()
        if own_files.is_own(name, value)
    }
    if differing := sorted(audit.files.keys() - named.keys()):
        yield _problem(f"No setting names the file that is here for {', '.join(differing)}.")
    for name, value in sorted(named.items()):
        if name not in audit.files:
            yield Finding(
                Level.WARNING, f"The file of the setting {name} is not here: its runs need it."
            )
        elif own_files.is_named(value, audit.files[name].encode()):
            yield _good(f"The file of the setting {name} is {value}.")
        else:
            yield _problem(f"The file of the setting {name} is another one than {value}.")


def _differing(frozen: CompetitionDocument, played: Round) -> Iterator[str]:
    plan = frozen.round(played.number)
    wanted = {
        "kind": plan.kind,
        "trials": plan.trials,
        "looks": plan.batches if isinstance(plan, Final) else 1,
        "ties": frozen.ties,
    }
    if frozen.benchmark in registry.BENCHMARKS:  # of a later version it may be one that is unknown
        protocol = frozen.base.protocol
        wanted["block"] = 1 if protocol is None else protocol.block
    yield from (name for name, value in wanted.items() if getattr(played, name) != value)


def _times(plan: AnyRound) -> tuple[float, float | None]:
    """Return when a round opens and closes; without an offset a time would depend on this host."""
    closes = None if isinstance(plan, Final) else plan.closes
    if plan.opens.tzinfo is None or (closes is not None and closes.tzinfo is None):
        raise ValueError("a time of the frozen document has no offset")
    return plan.opens.timestamp(), None if closes is None else closes.timestamp()


def _moved(played: Round, planned: tuple[float, float | None]) -> Iterator[Finding]:
    """Say whether a round was at another time than that of the frozen document."""
    if (played.opens_at, played.closes_at) == planned:
        return
    if not played.moves:
        yield _problem(
            f"{_name(played)}: it was not at the time of the frozen document, and no move says why."
        )
        return
    last = played.moves[-1]
    yield Finding(
        Level.WARNING,
        f"{_name(played)}: it was moved after the competition had opened, by "
        f"{(last.after - played.moves[0].before) / 3600.0:.3g} hours: {last.reason}",
    )


def _keys(audit: Audit, played: Round, entries: Sequence[Entry]) -> Iterator[Finding]:
    """Whether key and commitment belong together, and the seeds follow from the key."""
    name = _name(played)
    if played.key is None:
        yield Finding(
            Level.WARNING,
            f"{name}: its key is not revealed, so commitment and seeds cannot be checked.",
        )
        return
    key = bytes.fromhex(played.key)
    if commitment(key) != played.commitment:
        yield _problem(f"{name}: its key does not belong to the commitment {played.commitment}.")
    else:
        yield _good(f"{name}: its key belongs to the commitment {played.commitment}.")
    yield from _each(
        name,
        ("the seed follows from the key", "the seed does not follow from the key"),
        entries,
        (entry for entry in entries if entry.seed != _seed(audit, key, entry)),
    )


def _seed(audit: Audit, key: bytes, entry: Entry) -> int:
    label = entry.submission if entry.batch is None else final_label(entry.batch)
    return seed(key, audit.competition, label)


def _runs(played: Round, entries: Sequence[Entry]) -> Iterator[Finding]:
    """Whether each run fits what was submitted and the times and trials of its round."""
    name = _name(played)
    shown = [entry for entry in entries if entry.submitted is not None]
    yield from _each(
        name,
        (
            "the digest of the submission is that of what was submitted",
            "the digest of the submission is not that of what was submitted",
        ),
        shown,
        (each for each in shown if digest_of(each.submitted or {}) != each.submission),
    )
    if len(shown) < len(entries):
        hidden = len(entries) - len(shown)
        yield Finding(
            Level.WARNING,
            f"{name}: {_count(hidden)} {'does' if hidden == 1 else 'do'} not show what was "
            "submitted, so the digest of the submission cannot be checked.",
        )
    yield from _each(
        name,
        (
            f"the score is the mean of {played.trials} trials",
            f"the score is not the mean of {played.trials} trials",
        ),
        entries,
        (entry for entry in entries if not _is_scored(entry, played.trials)),
    )
    if played.kind != RoundKind.FINAL:  # its entries were submitted before
        teams = [entry for entry in entries if entry.team is not None]
        yield from _each(
            name,
            ("a team submitted while the round was open", "the round was not open for the team"),
            teams,
            (entry for entry in teams if not _is_open(played, entry.submitted_at)),
        )


def _is_scored(entry: Entry, trials: int) -> bool:
    if entry.scores is None or entry.score is None:
        return entry.scores is None and entry.score is None
    return len(entry.scores) == trials and _alike(entry.score, mean(entry.scores))


def _is_open(played: Round, at: float) -> bool:
    after = played.opens_at is None or played.opens_at <= at
    return after and (played.closes_at is None or at <= played.closes_at)


def _final(audit: Audit, final: Round, entries: Sequence[Entry]) -> Iterator[Finding]:
    """Whether the standings follow from the scores, and the final ended when it had to."""
    if audit.standings is None:
        yield Finding(Level.WARNING, f"{_name(final)}: it has no standings yet.")
        return
    batches = audit.standings.batches
    finalists: dict[int, dict[int, Entry]] = defaultdict(dict)
    for entry in entries:
        if entry.team is not None and entry.batch is not None:
            finalists[entry.key][entry.batch] = entry
    wrong = [*_misfits(final, batches, finalists)]
    if wrong:
        yield from map(_problem, wrong)
        return
    work = len(finalists) ** 2 * final.trials * batches * (batches + 1) / 4.0
    if work > WORK_MAX or len(finalists) > FINALISTS_MAX:
        raise AuditInvalid(
            f"the final is too large to be checked: {len(finalists)} finalists, {batches} batches "
            f"of {final.trials} trials"
        )
    looks = [_standings(final, finalists, batch) for batch in range(1, batches + 1)]
    yield _compared(final, audit.standings.placings, looks[-1].placings)
    yield _ended(final, looks, says=audit.standings.separated)


def _board(audit: Audit, played: Round, entries: Sequence[Entry]) -> Finding:
    """Whether the places of a competition without a final follow from the scores."""
    if audit.board is None:
        return Finding(Level.WARNING, f"{_name(played)}: it has no places yet.")
    best: dict[tuple[str, str], Entry] = {}
    for entry in sorted(entries, key=_by_score):
        if entry.team is not None and entry.scores is not None:
            best.setdefault((entry.team, entry.method.casefold()), entry)
    if len(best) > METHODS_MAX:
        raise AuditInvalid(f"round {played.number} is too large to be checked: {len(best)} methods")
    rows = [*best.values()]
    results = [summary(entry.scores or (), played.block) for entry in rows]
    ranges = rank_ranges(
        [
            Estimate(score=one.score or 0.0, standard_error=one.standard_error, degrees=one.degrees)
            for one in results
        ]
    )
    computed = [
        Placing(
            key=entry.key,
            place=low if played.ties == Ties.SHARED else place,
            place_low=low,
            place_high=high,
            score=result.score,
            score_low=result.low,
            score_high=result.high,
        )
        for place, (entry, result, (low, high)) in enumerate(
            zip(rows, results, ranges, strict=True), 1
        )
    ]
    return _compared(played, audit.board, computed)


def _by_score(entry: Entry) -> tuple[float, float, int]:
    """Return by what entries are ordered: the best first, of equal ones the earlier one."""
    return -(entry.score or 0.0), entry.submitted_at, entry.run


def _misfits(
    final: Round, batches: int, finalists: Mapping[int, Mapping[int, Entry]]
) -> Iterator[str]:
    """Yield why no standings can be computed."""
    name = _name(final)
    if batches > final.looks:
        yield f"{name}: it had {batches} batches, of at most {final.looks}."
    for key, runs in finalists.items():
        first = next(iter(runs.values()))
        same = (first.team, first.method, first.submission, first.submitted_at)
        if any((e.team, e.method, e.submission, e.submitted_at) != same for e in runs.values()):
            yield f"{name}: finalist {key} is not the same submission in all batches."
        if any(batch > batches for batch in runs):
            yield f"{name}: finalist {key} has a run after the last batch, {batches}."
        lengths = {final.trials, *(len(e.scores) for e in runs.values() if e.scores is not None)}
        if len(lengths) > 1:
            yield f"{name}: finalist {key} has another number of trials than {final.trials}."
        failed = min((batch for batch in runs if runs[batch].scores is None), default=batches)
        missing = [batch for batch in range(1, failed + 1) if batch not in runs]
        if missing:
            yield f"{name}: finalist {key} has no run in batch {missing[0]}."


def _standings(
    final: Round, finalists: Mapping[int, Mapping[int, Entry]], batches: int
) -> Standings:
    """Return the standings after some batches."""
    return decide(
        [
            Finalist(
                key=key,
                submitted_at=next(iter(runs.values())).submitted_at,
                scores=_scores(runs, batches),
            )
            for key, runs in finalists.items()
        ],
        block=final.block,
        looks=final.looks,
        ties=final.ties,
    )


def _scores(runs: Mapping[int, Entry], batches: int) -> list[float] | None:
    """Return the scores of a finalist in its first batches; None if one of these runs failed."""
    scores: list[float] = []
    for batch in range(1, batches + 1):
        run = runs.get(batch)
        if run is None or run.scores is None:
            return None
        scores += run.scores
    return scores


def _compared(played: Round, stated: Sequence[Placing], computed: Sequence[Placing]) -> Finding:
    name, keys = _name(played), [each.key for each in computed]
    if [each.key for each in stated] != keys:
        return _problem(
            f"{name}: the order of the standings does not follow from the scores, which give "
            f"{_listed(keys)} (keys of the entries, the best first)."
        )
    pairs = zip(stated, computed, strict=True)
    wrong = [one.key for one, other in pairs if not _same_placing(one, other)]
    if wrong:
        return _problem(
            f"{name}: places, ranges or scores do not follow from the scores of the trials for the "
            f"entries {_listed(wrong)}."
        )
    entries = f"{len(keys)} {'entry' if len(keys) == 1 else 'entries'}"
    return _good(f"{name}: the standings of {entries} follow from the scores.")


def _same_placing(one: Placing, other: Placing) -> bool:
    places = one.place, one.place_low, one.place_high
    if places != (other.place, other.place_low, other.place_high):
        return False
    stated = one.score, one.score_low, one.score_high
    return all(map(_alike, stated, (other.score, other.score_low, other.score_high)))


def _ended(final: Round, looks: Sequence[Standings], *, says: bool) -> Finding:
    """Whether the final ended at the first batch that separated its ranks, or with the last one."""
    name, batches = _name(final), len(looks)
    if says != looks[-1].separated:
        is_apart = "are" if looks[-1].separated else "are not"
        return _problem(f"{name}: after {batches} batches its ranks {is_apart} separated.")
    early = next((at for at, look in enumerate(looks[:-1], 1) if look.separated), None)
    if early is not None:
        return _problem(f"{name}: its ranks were separated after batch {early}, but it went on.")
    if not says and batches < final.looks:
        return _problem(
            f"{name}: its ranks are not separated, but it ended after {batches} of "
            f"{final.looks} batches."
        )
    why = "its ranks were separated" if says else "there may be no more"
    return _good(f"{name}: it ended after {batches} batches, since {why}.")


def _alike(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    return isclose(one, other, rel_tol=_ROUNDING, abs_tol=_ROUNDING)


def _each(
    name: str, says: tuple[str, str], checked: Sequence[Entry], wrong: Iterable[Entry]
) -> Iterator[Finding]:
    """Yield a sentence about the runs of a round that were checked, if there are any.

    `says` is what is right of a run, and what is wrong.
    """
    right_says, wrong_says = says
    runs = [entry.run for entry in wrong]
    if runs:
        yield _problem(
            f"{name}: in {len(runs)} of {_count(len(checked))}, {wrong_says}: {_listed(runs)}."
        )
    elif checked:
        which = "1 run" if len(checked) == 1 else f"each of {_count(len(checked))}"
        yield _good(f"{name}: in {which}, {right_says}.")


def _count(runs: int) -> str:
    return f"{runs} {'run' if runs == 1 else 'runs'}"


def _listed(numbers: Sequence[int]) -> str:
    shown = ", ".join(map(str, numbers[:SHOWN]))
    return f"{shown} and {len(numbers) - SHOWN} more" if len(numbers) > SHOWN else shown


def _name(played: Round) -> str:
    return f"Round {played.number} ({played.kind})"


def _good(sentence: str) -> Finding:
    return Finding(Level.GOOD, sentence)


def _problem(sentence: str) -> Finding:
    return Finding(Level.PROBLEM, sentence)

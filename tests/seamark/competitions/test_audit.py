"""An audit finds whatever was changed in a document, and reads nothing that is too large."""

import copy
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import pytest

from seamark.competitions import audit, audit_document
from seamark.competitions.audit import verify
from seamark.competitions.audit_document import AuditInvalid, as_document, load, read
from seamark.competitions.document import digest_of
from seamark.competitions.findings import Level
from seamark.competitions.standings import Standings, Ties
from tests.seamark.competitions.audits import RECORD_NAME, document, small, without_final

Path = tuple[str | int, ...]
# What follows from nothing else in the document: what the service says.
STATED = {"method", "run", "digest"}
DOCUMENT = json.loads(json.dumps(document()))  # as in a file


def problems(changed: dict[str, Any]) -> list[str]:
    return [each.sentence for each in verify(changed) if each.level == Level.PROBLEM]


def warnings(changed: dict[str, Any]) -> list[str]:
    return [each.sentence for each in verify(changed) if each.level == Level.WARNING]


def leaves(value: Any, path: Path = ()) -> Iterator[Path]:
    """Yield the path of each value that is no object and no list."""
    inner: list[tuple[str | int, Any]] = []
    if isinstance(value, dict):
        inner = [*value.items()]
    elif isinstance(value, list):
        inner = [*enumerate(value)]
    for key, each in inner:
        yield from leaves(each, (*path, key))
    if not isinstance(value, dict | list):
        yield path


def at(root: Any, path: Sequence[str | int]) -> Any:
    for key in path:
        root = root[key]
    return root


def changed(path: Path, value: Any) -> dict[str, Any]:
    """Return the document with another value."""
    copied: dict[str, Any] = copy.deepcopy(DOCUMENT)
    at(copied, path[:-1])[path[-1]] = value
    return copied


def other(value: Any) -> Any:
    """Return another value of the same type: another digest, name, number or choice."""
    choices = {"practice": "qualification", "qualification": "practice", "earlier": "shared"}
    if isinstance(value, bool) or value is None:
        return not value if isinstance(value, bool) else 1
    if isinstance(value, str):
        turned = value[:-1] + ("0" if value[-1:] != "0" else "1")
        return choices.get(value, turned)
    return value + 1


def found(path: Path) -> bool:
    """Tell whether a changed value is noticed."""
    try:
        return bool(problems(changed(path, other(at(DOCUMENT, path)))))
    except AuditInvalid:
        return True


def test_a_document_in_which_everything_is_right_has_only_good_findings() -> None:
    findings = verify(DOCUMENT)

    assert {each.level for each in findings} == {Level.GOOD}
    assert "Round 3 (final): in each of 10 runs, the seed follows from the key." in {
        each.sentence for each in findings
    }
    assert findings[2].sentence == f"The file of the setting current_record is {RECORD_NAME}."
    assert findings[4].sentence == "Round 1 (practice): in 1 run, the seed follows from the key."
    assert findings[-2].sentence == (
        "Round 3 (final): the standings of 4 entries follow from the scores."
    )
    assert findings[-1].sentence == (
        "Round 3 (final): it ended after 2 batches, since its ranks were separated."
    )


def test_every_value_that_follows_from_others_is_checked() -> None:
    """Each value of the document is changed in turn."""
    unnoticed = {path for path in leaves(DOCUMENT) if not found(path)}

    left = {path for path in unnoticed if path[-1] not in STATED}
    # Outside the final nothing is decided: who submitted, and when, if the round was open.
    assert {path[0] for path in left} == {"entries"}
    assert {path[-1] for path in left} == {"key", "team", "submitted_at"}
    finalists = [
        at
        for at, entry in enumerate(DOCUMENT["entries"])
        if entry["round"] == 3 and entry["team"] is not None
    ]
    assert not {path[1] for path in left} & set(finalists)


@pytest.mark.parametrize(
    ("path", "value", "sentence"),
    [
        (("frozen", "settings", "levels", 0), 0.1, "frozen document does not have the SHA-256"),
        (("frozen_sha256",), "0" * 64, "frozen document does not have the SHA-256"),
        (("rounds", 1, "key"), "0" * 64, "Round 2 (qualification): its key does not belong"),
        (("rounds", 1, "commitment"), "0" * 64, "(qualification): its key does not belong"),
        (("files", "current_record"), "another", "current_record is another one than record@"),
        (("files", "vehicle"), "mine", "No setting names the file that is here for vehicle."),
        (("competition",), "wreck", "in 10 of 10 runs, the seed does not follow"),
        (("entries", 0, "seed"), 5, "(practice): in 1 of 1 run, the seed does not follow from"),
        (
            ("entries", 0, "submission"),
            "0" * 64,
            "(practice): in 1 of 1 run, the digest of the submission is not",
        ),
        (("entries", 0, "submitted", "program"), "0", "the digest of the submission is not that"),
        (("entries", 1, "score"), 0.3, "(qualification): in 1 of 2 runs, the score is not"),
        (("entries", 1, "scores", 2), 0.3, "(qualification): in 1 of 2 runs, the score is not"),
        (("entries", 1, "scores"), [0.2], "(qualification): in 1 of 2 runs, the score is not"),
        (("entries", 2, "score"), 0.2, "(qualification): in 1 of 2 runs, the score is not"),
        (("entries", 1, "submitted_at"), 5000.0, "in 1 of 2 runs, the round was not open"),
        (("rounds", 1, "opens_at"), 2600.0, "in 2 of 2 runs, the round was not open"),
        (("rounds", 2, "looks"), 1, "it had 2 batches, of at most 1"),
        (("rounds", 2, "looks"), 9, "Not as in the frozen document: looks of round 3."),
        (("rounds", 2, "ties"), "shared", "Not as in the frozen document: ties of round 3."),
        (("rounds", 1, "block"), 2, "Not as in the frozen document: block of round 2."),
        (("rounds", 1, "trials"), 7, "Not as in the frozen document: trials of round 2."),
        (("rounds", 1, "kind"), "practice", "Not as in the frozen document: kind of round 2."),
        (("title",), "Another", "Not as in the frozen document: title."),
        (("benchmark",), "currents-v2", "Not as in the frozen document: benchmark."),
        (("frozen", "rounds"), [], "none that this version of Seamark can read"),
        (("frozen", "rounds", 0, "opens"), "0001-01-01T00:00:00", "none that this version of"),
        (("frozen", "rounds", 0, "closes"), "1970-01-01T00:33:19", "none that this version of"),
        (("frozen", "rounds", 0, "opens"), "0001-01-01T00:00:00+14:00", "it was not at the time"),
        (("rounds", 0, "opens_at"), 900.0, "Round 1 (practice): it was not at the time of the"),
        (("rounds", 1, "closes_at"), 9000.0, "Round 2 (qualification): it was not at the time"),
        (("rounds", 2, "opens_at"), 4000.0, "Round 3 (final): it was not at the time"),
        (("standings", "batches"), 1, "finalist 21 has a run after the last batch, 1"),
        (("standings", "batches"), 3, "finalist 21 has no run in batch 3"),
        (("standings", "separated"), False, "after 2 batches its ranks are separated"),
        (("standings", "placings", 0, "place_high"), 2, "for the entries 21."),
        (("standings", "placings", 1, "score"), 0.3, "for the entries 22."),
        (("standings", "placings", 1, "score_low"), None, "for the entries 22."),
        (("standings", "placings", 3, "place"), 4, "for the entries 24."),
        (("standings", "placings", 0, "key"), 22, "the order of the standings does not follow"),
        (("standings", "placings"), [], "give 21, 22, 23, 24 (keys"),
        (("entries", 4, "team"), "another", "finalist 21 is not the same submission in all"),
        (("entries", 4, "method"), "another", "finalist 21 is not the same submission in all"),
        (("entries", 4, "submitted_at"), 1.0, "finalist 21 is not the same submission in all"),
        (("entries", 3, "scores"), [0.5] * 7, "finalist 21 has another number of trials"),
    ],
)
def test_what_is_wrong_is_said(path: Path, value: Any, sentence: str) -> None:
    assert any(sentence in each for each in problems(changed(path, value)))


@pytest.mark.parametrize("ties", Ties)
def test_places_without_a_final_follow_from_the_best_entry_of_each_method(ties: Ties) -> None:
    document = json.loads(json.dumps(without_final(ties)))
    findings = verify(document)

    assert {each.level for each in findings} == {Level.GOOD}
    assert findings[-1].sentence == (
        "Round 2 (qualification): the standings of 4 entries follow from the scores."
    )
    for path in leaves(document["board"]):
        wrong = copy.deepcopy(document)
        at(wrong["board"], path[:-1])[path[-1]] = other(at(wrong["board"], path))
        assert problems(wrong), path
    missing = document | {"board": document["board"][1:]}
    assert any("give 33, 34, 31, 35 (keys" in each for each in problems(missing))


def test_places_that_are_missing_or_too_many_are_said() -> None:
    document = json.loads(json.dumps(without_final()))
    both = DOCUMENT | {"board": document["board"]}

    assert warnings(document | {"board": None}) == [
        "Round 2 (qualification): it has no places yet."
    ]
    assert problems(both) == ["There are places of a qualification, but the final decides."]


def test_a_round_with_too_many_methods_is_not_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(audit, "METHODS_MAX", 3)

    with pytest.raises(AuditInvalid, match="round 2 is too large to be checked: 4 methods"):
        verify(without_final())


def test_a_file_of_the_organisers_that_is_missing_is_said() -> None:
    document = changed(("files",), {})

    assert problems(document) == []
    assert warnings(document) == [
        "The file of the setting current_record is not here: its runs need it."
    ]


@pytest.mark.parametrize(
    ("files", "sentence"),
    [
        (None, "files is no object"),
        ({"levels": "0"}, "files has the unknown field 'levels'"),
        ({"current_record": 5}, "current_record is no text of at most"),
        ({"current_record": "\ud800"}, "current_record is no text of at most"),
        ({"vehicle": "x" * (audit_document.FILE_BYTES_MAX + 1)}, "vehicle is no text of at most"),
    ],
)
def test_files_that_are_none_are_refused(files: Any, sentence: str) -> None:
    with pytest.raises(AuditInvalid, match=sentence):
        read(changed(("files",), files))


def test_a_finalist_that_is_better_on_other_trials_gets_another_place() -> None:
    swapped = changed(("rounds", 2, "ties"), "earlier")
    for entry in swapped["entries"]:
        if entry["round"] == 3 and entry["scores"] is not None:
            entry["scores"] = [1.0 - score for score in entry["scores"]]
            entry["score"] = 1.0 - entry["score"]

    assert any("give 23, 22, 21, 24 (keys" in each for each in problems(swapped))


def test_a_final_that_went_on_though_its_ranks_were_separated_is_found() -> None:
    """The one that leads after the first batch might not lead after the second."""
    went_on = copy.deepcopy(DOCUMENT)
    for entry in went_on["entries"]:
        if entry["key"] == 21 and entry["batch"] is not None:
            entry["scores"] = [score + 1.0 for score in entry["scores"]]
            entry["score"] += 1.0
    decided = audit._standings(read(went_on).rounds[2], _runs_of(went_on), 2)
    went_on["standings"] |= {"placings": as_document(_with(decided))["standings"]["placings"]}

    assert problems(went_on) == [
        "Round 3 (final): its ranks were separated after batch 1, but it went on."
    ]


def test_a_final_that_ended_too_early_is_found() -> None:
    """With the first batch alone, two are not apart."""
    early = copy.deepcopy(DOCUMENT)
    early["entries"] = [entry for entry in early["entries"] if entry["batch"] != 2]
    decided = audit._standings(read(early).rounds[2], _runs_of(early), 1)
    early["standings"] = as_document(_with(decided))["standings"] | {"batches": 1}

    assert problems(early) == [
        "Round 3 (final): its ranks are not separated, but it ended after 1 of 5 batches."
    ]


def test_a_final_may_end_unseparated_with_its_last_batch() -> None:
    """Two finalists that differ by luck alone, and a document with two batches at most."""
    last = copy.deepcopy(DOCUMENT)
    for entry, other_entry in zip(last["entries"][3:5], last["entries"][5:7], strict=True):
        scores = [*reversed(entry["scores"])]
        other_entry |= {"scores": scores, "score": entry["score"]}
    last["frozen"]["rounds"][2]["batches"] = last["rounds"][2]["looks"] = 2
    last["frozen_sha256"] = digest_of(last["frozen"])
    decided = audit._standings(read(last).rounds[2], _runs_of(last), 2)
    last["standings"] = as_document(_with(decided))["standings"]

    assert problems(last) == []
    assert verify(last)[-1].sentence == (
        "Round 3 (final): it ended after 2 batches, since there may be no more."
    )


def _runs_of(changed: dict[str, Any]) -> dict[int, dict[int, audit_document.Entry]]:
    runs: dict[int, dict[int, audit_document.Entry]] = {}
    for entry in read(changed).entries:
        if entry.batch is not None and entry.team is not None:
            runs.setdefault(entry.key, {})[entry.batch] = entry
    return runs


def _with(decided: Standings) -> audit_document.Audit:
    decision = audit_document.Decision(
        batches=2, separated=decided.separated, placings=decided.placings
    )
    return replace(small(), standings=decision)


def test_a_finalist_that_failed_in_a_later_batch_has_no_place() -> None:
    failed = copy.deepcopy(DOCUMENT)
    failed["entries"][4] |= {"scores": None, "score": None}

    assert any("give 22, 23, 21, 24 (keys" in each for each in problems(failed))


def test_a_finalist_that_failed_need_not_run_again() -> None:
    once = copy.deepcopy(DOCUMENT)
    once["entries"] = [
        entry for entry in once["entries"] if (entry["key"], entry["batch"]) != (24, 2)
    ]

    assert problems(once) == []


def test_a_round_whose_key_is_not_revealed_is_said() -> None:
    assert warnings(changed(("rounds", 2, "key"), None)) == [
        "Round 3 (final): its key is not revealed, so commitment and seeds cannot be checked."
    ]
    assert problems(changed(("rounds", 2, "key"), None)) == []


def test_a_round_that_was_moved_is_said_with_the_reason() -> None:
    move = {"at": 1500.0, "before": 2999.0, "after": 10199.0, "reason": "A storm."}
    moved = changed(("rounds", 1), DOCUMENT["rounds"][1] | {"closes_at": 10199.0, "moves": [move]})

    assert problems(moved) == []
    assert warnings(moved) == [
        "Round 2 (qualification): it was moved after the competition had opened, by 2 hours: "
        "A storm."
    ]


def test_what_was_submitted_may_be_hidden_but_that_is_said() -> None:
    assert warnings(changed(("entries", 0, "submitted"), None)) == [
        "Round 1 (practice): 1 run does not show what was submitted, so the digest of the "
        "submission cannot be checked."
    ]


def test_a_final_without_standings_has_not_ended() -> None:
    assert warnings(changed(("standings",), None)) == ["Round 3 (final): it has no standings yet."]


def test_standings_without_a_final_are_found() -> None:
    alone = copy.deepcopy(DOCUMENT)
    alone["rounds"].pop()
    alone["entries"] = [entry for entry in alone["entries"] if entry["round"] != 3]

    assert problems(alone) == [
        "The rounds are not those of the frozen document.",
        "There are standings of a final, but no final.",
    ]


def test_many_wrong_runs_are_counted_and_not_all_named() -> None:
    many = copy.deepcopy(DOCUMENT)
    many["entries"] += [
        many["entries"][0] | {"key": 1000 + at, "run": at, "seed": 0} for at in range(15)
    ]

    assert problems(many) == [
        "Round 1 (practice): in 15 of 16 runs, the seed does not follow from the key: 0, 1, 2, 3, "
        "4, 5, 6, 7, 8, 9 and 5 more."
    ]


def test_a_document_survives_writing_and_reading() -> None:
    assert as_document(read(load(json.dumps(document()).encode()))) == DOCUMENT


def test_the_rule_for_ties_is_applied() -> None:
    """Two copies of a program, of which the document says that the earlier one is first."""
    copies = copy.deepcopy(DOCUMENT)
    for entry, other_entry in zip(copies["entries"][3:5], copies["entries"][5:7], strict=True):
        other_entry |= {"scores": entry["scores"], "score": entry["score"]}
    decided = audit._standings(read(copies).rounds[2], _runs_of(copies), 2)
    copies["standings"] = as_document(_with(decided))["standings"]
    assert not any("for the finalists" in each for each in problems(copies))

    copies["rounds"][2]["ties"] = Ties.SHARED

    assert any("for the entries 22." in each for each in problems(copies))


@pytest.mark.parametrize("path", [*leaves(DOCUMENT)], ids=lambda path: ".".join(map(str, path)))
def test_a_value_of_another_type_is_refused_or_found(path: Path) -> None:
    """Nothing that a stranger writes into a field is an exception of another kind."""
    values: list[Any] = [None, True, "", "x", "\ud800", -1, 2.5, 10**400, 1e300, [], {}, [[]]]
    for value in values:
        try:
            verify(changed(path, value))
        except AuditInvalid:
            continue


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda d: d.pop("rounds"), "the document has no field rounds"),
        (lambda d: d.update(more=1), "unknown field 'more'"),
        (lambda d: d.update(format="seamark competition audit 2"), "the format is not"),
        (lambda d: d.update(title="a\nb"), "title is no printable text"),
        (lambda d: d.update(title="a" * 501), "title is no printable text"),
        (lambda d: d.update(frozen=[]), "frozen is no object"),
        (lambda d: d.update(rounds=[1]), "round 1 is no object"),
        (lambda d: d.update(rounds=d["rounds"] * 40), "rounds is no list of at most 100 items"),
        (lambda d: d.update(rounds=d["rounds"] * 2), "two rounds have the same number"),
        (lambda d: d["rounds"][0].update(kind="final"), "more than one final"),
        (
            lambda d: d["rounds"][0].update(kind="other"),
            "round 1: kind is none of check, practice, ",
        ),
        (lambda d: d["rounds"][0].update(kind="check"), "the check of a draft belongs to no audit"),
        (lambda d: d["rounds"][0].update(key="ABCD"), "round 1: key is not 64"),
        (lambda d: d["rounds"][0].update(block=4), "6 trials are no blocks of 4"),
        (lambda d: d["rounds"][0].update(trials=True), "trials is no whole number from 1 to 1000"),
        (lambda d: d["entries"][0].update(round=9), "entry 1 belongs to round 9"),
        (lambda d: d["entries"][0].update(batch=1), "exactly the entries of a final"),
        (lambda d: d["entries"][3].update(batch=None), "exactly the entries of a final"),
        (lambda d: d["entries"][3].update(batch=2), "entry 5: its key occurs twice"),
        (lambda d: d["entries"][0].update(scores=[1.0] * 1001), "scores is no list of at most"),
        (lambda d: d["entries"][0].update(scores=[float("nan")]), "no list of numbers of moderate"),
        (lambda d: d["entries"][0].update(submitted_at="now"), "submitted_at is no number"),
        (lambda d: d["entries"][0].update(submitted={"a": float("inf")}), "no object of JSON"),
        (lambda d: d["standings"].update(separated=1), "separated is neither true nor false"),
    ],
)
def test_a_document_that_does_not_fit_is_refused_with_the_place(
    change: Callable[[dict[str, Any]], None], word: str
) -> None:
    wrong = copy.deepcopy(DOCUMENT)
    change(wrong)

    with pytest.raises(AuditInvalid, match=word):
        verify(wrong)


def test_an_object_that_is_nested_too_deeply_is_refused() -> None:
    deep: dict[str, Any] = {}
    for _ in range(50):
        deep = {"inner": [deep]}

    with pytest.raises(AuditInvalid, match="frozen is nested more than 20 deep"):
        verify(changed(("frozen",), deep))


@pytest.mark.parametrize(
    ("content", "word"),
    [
        (b"[" * 200_000, "nested too deeply"),
        (b"\xff", "no JSON"),
        (b"{", "no JSON"),
        (b"[]", "no JSON object"),
        (b'{"a": NaN}', "NaN is no number of JSON"),
        (b'{"a": 1, "a": 2}', "a name occurs twice"),
        (b'{"a": ' + b"9" * 5000 + b"}", "no JSON"),
        (b" " * (audit_document.BYTES_MAX + 1), "more than 32 MiB"),
        (b"[" + b"[]," * 2_000_000 + b"[]]", "more than 4000000 values"),
    ],
    ids=range(9),
)
def test_a_file_that_is_no_document_is_refused(content: bytes, word: str) -> None:
    with pytest.raises(AuditInvalid, match=word):
        load(content)


def test_a_final_whose_standings_would_take_too_long_is_refused() -> None:
    """1000 finalists with ten batches of six trials: 1.65e8 pairs times trials."""
    long = copy.deepcopy(DOCUMENT)
    long["entries"] = [
        long["entries"][3] | {"key": key, "batch": batch}
        for key in range(1000)
        for batch in range(1, 11)
    ]
    long["rounds"][2]["looks"] = long["standings"]["batches"] = 10

    with pytest.raises(AuditInvalid, match="too large to be checked: 1000 finalists, 10 batches"):
        verify(long)


def test_a_final_with_too_many_finalists_is_refused() -> None:
    large = copy.deepcopy(DOCUMENT)
    large["entries"] = [
        large["entries"][3] | {"key": key, "run": key} for key in range(audit.FINALISTS_MAX + 1)
    ]
    large["standings"]["batches"] = 1

    with pytest.raises(AuditInvalid, match="too large to be checked: 2001 finalists"):
        verify(large)

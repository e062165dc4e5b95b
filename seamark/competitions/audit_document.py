"""The audit document of a competition: what it holds, and how a stranger's one is read.

It is one JSON object. docs/competitions.md describes its fields. Reading takes bounded time and
memory, whatever is in the file: sizes, counts and depth are limited, and what does not fit is
refused with a sentence that says where.
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

from seamark.competitions.document import RoundKind, digest_of
from seamark.competitions.standings import Placing, Ties
from seamark.sim.settings import own_files

FORMAT = "seamark competition audit 1"
BYTES_MAX = 32 * 2**20  # of the file: 5000 runs of 24 trials with 150 settings have 18 MiB
VALUES_MAX = 4_000_000  # of the file, of which 5000 such runs have a million; 70 bytes for each
ROUNDS_MAX = 100
MOVES_MAX = 1000
ENTRIES_MAX = 50_000
TRIALS_MAX = 1000  # of a run
TEXT_MAX = 500  # [character]
DEPTH_MAX = 20  # of objects and lists within each other
FILE_BYTES_MAX = 4 * 2**20  # of the organiser: a record of currents has at most half of it
_WHOLE_MAX = 2**63 - 1
_SHA256 = re.compile(r"[0-9a-f]{64}")
_Value = TypeVar("_Value")


class AuditInvalid(Exception):
    """A document cannot be read; the text says where and why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Move:
    """A later end of a round, or beginning of a final, than was announced before."""

    at: float  # when it was announced
    before: float
    after: float
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Round:
    """A round and how it is decided. Times are in seconds since 1970, UTC; None: no limit."""

    number: int
    kind: RoundKind
    opens_at: float | None
    closes_at: float | None
    commitment: str  # SHA-256 of the key, published before the round
    key: str | None  # in hex; None: not yet revealed
    trials: int  # of a run; in a final, of a batch
    block: int  # RankedProtocol.block
    looks: int  # the largest number of batches; 1 unless it is a final
    ties: Ties
    moves: Sequence[Move]


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """A run that counts: of a submission, or of a finalist in one batch."""

    round: int
    key: int  # of the submission: a finalist has the same one in each batch
    batch: int | None  # from 1; None unless the round is a final
    team: str | None  # None: a reference entry, which has no place
    method: str
    submitted_at: float
    submission: str  # SHA-256 of what was submitted
    submitted: Mapping[str, Any] | None  # of which that is the SHA-256; None: it is not shown
    run: int  # its number on the service
    seed: int
    scores: Sequence[float] | None  # of each trial; None: the run failed
    score: float | None  # their mean
    digest: str | None  # of the telemetry


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """How a final ended."""

    batches: int
    separated: bool
    placings: Sequence[Placing]  # the best first


@dataclass(frozen=True, slots=True, kw_only=True)
class Audit:
    """All that is needed to check a competition."""

    competition: str  # its name
    title: str
    benchmark: str  # the base
    frozen: Mapping[str, Any]  # CompetitionDocument.canonical
    frozen_sha256: str
    files: Mapping[str, str]  # setting -> text of the organiser's own file that it names
    rounds: Sequence[Round]
    entries: Sequence[Entry]
    standings: Decision | None  # of the final; None before its end
    # Of the qualification, one for each method, if it decides; None before that.
    board: Sequence[Placing] | None


def as_document(audit: Audit) -> dict[str, Any]:
    """Return the JSON object; `read` is the inverse."""
    return {"format": FORMAT, **asdict(audit)}


def load(content: bytes) -> dict[str, Any]:
    """Return the JSON object of a file.

    Raises
    ------
    AuditInvalid
        If it is too large, no JSON or no object, or if a name occurs twice in one object.
    """
    if len(content) > BYTES_MAX:
        raise AuditInvalid(f"the file has more than {BYTES_MAX // 2**20} MiB")
    if sum(map(content.count, (b",", b"[", b"{"))) > VALUES_MAX:
        raise AuditInvalid(f"the file has more than {VALUES_MAX} values")
    try:
        document = json.loads(
            content.decode(), object_pairs_hook=_unique, parse_constant=_no_constant
        )
    except RecursionError:
        raise AuditInvalid("the file is nested too deeply") from None
    except ValueError as error:  # also of bytes that are no UTF-8
        raise AuditInvalid(f"the file is no JSON: {error}") from None
    if not isinstance(document, dict):
        raise AuditInvalid("the file is no JSON object")
    return document


def read(document: Mapping[str, Any]) -> Audit:
    """Return the audit of a JSON object.

    Raises
    ------
    AuditInvalid
        If a field is missing, unknown, of another type or too large, or if the entries do not fit
        the rounds.
    """
    fields = _Fields(document, "the document")
    if fields.text("format") != FORMAT:
        raise AuditInvalid(f"the format is not {FORMAT!r}")
    audit = Audit(
        competition=fields.text("competition"),
        title=fields.text("title"),
        benchmark=fields.text("benchmark"),
        frozen=fields.object("frozen"),
        frozen_sha256=fields.sha256("frozen_sha256"),
        files=_files(_Fields(fields.take("files"), "files")),
        rounds=[
            _round(_Fields(each, f"round {at}"))
            for at, each in enumerate(fields.list("rounds", ROUNDS_MAX), 1)
        ],
        entries=[
            _entry(_Fields(each, f"entry {at}"))
            for at, each in enumerate(fields.list("entries", ENTRIES_MAX), 1)
        ],
        standings=fields.optional("standings", lambda: _decision(fields)),
        board=fields.optional("board", lambda: _placings(fields, "board")),
    )
    fields.end()
    _check_references(audit)
    return audit


def _round(fields: "_Fields") -> Round:
    read = Round(
        number=fields.whole("number"),
        kind=fields.one_of("kind", RoundKind),
        opens_at=fields.optional("opens_at", lambda: fields.number("opens_at")),
        closes_at=fields.optional("closes_at", lambda: fields.number("closes_at")),
        commitment=fields.sha256("commitment"),
        key=fields.optional("key", lambda: fields.sha256("key")),  # has as many digits
        trials=fields.whole("trials", 1, TRIALS_MAX),
        block=fields.whole("block", 1, TRIALS_MAX),
        looks=fields.whole("looks", 1, TRIALS_MAX),
        ties=fields.one_of("ties", Ties),
        moves=[
            _move(_Fields(each, f"{fields.where}, move {at}"))
            for at, each in enumerate(fields.list("moves", MOVES_MAX), 1)
        ],
    )
    fields.end()
    if read.kind is RoundKind.CHECK:
        raise AuditInvalid(f"{fields.where}: the check of a draft belongs to no audit")
    if read.trials % read.block:
        raise AuditInvalid(f"{fields.where}: {read.trials} trials are no blocks of {read.block}")
    return read


def _files(fields: "_Fields") -> dict[str, str]:
    read = {
        setting: fields.content(setting, FILE_BYTES_MAX)
        for setting in own_files.SETTINGS
        if fields.has(setting)
    }
    fields.end()
    return read


def _move(fields: "_Fields") -> Move:
    read = Move(
        at=fields.number("at"),
        before=fields.number("before"),
        after=fields.number("after"),
        reason=fields.text("reason"),
    )
    fields.end()
    return read


def _entry(fields: "_Fields") -> Entry:
    read = Entry(
        round=fields.whole("round"),
        key=fields.whole("key"),
        batch=fields.optional("batch", lambda: fields.whole("batch", 1, TRIALS_MAX)),
        team=fields.optional("team", lambda: fields.text("team")),
        method=fields.text("method"),
        submitted_at=fields.number("submitted_at"),
        submission=fields.sha256("submission"),
        submitted=fields.optional("submitted", lambda: fields.object("submitted")),
        run=fields.whole("run"),
        seed=fields.whole("seed"),
        scores=fields.optional("scores", lambda: fields.numbers("scores", TRIALS_MAX)),
        score=fields.optional("score", lambda: fields.number("score")),
        digest=fields.optional("digest", lambda: fields.text("digest")),
    )
    fields.end()
    return read


def _decision(fields: "_Fields") -> Decision:
    inner = _Fields(fields.take("standings"), "the standings")
    read = Decision(
        batches=inner.whole("batches", 1, TRIALS_MAX),
        separated=inner.flag("separated"),
        placings=_placings(inner, "placings"),
    )
    inner.end()
    return read


def _placings(fields: "_Fields", name: str) -> list[Placing]:
    return [
        _placing(_Fields(each, f"placing {at}"))
        for at, each in enumerate(fields.list(name, ENTRIES_MAX), 1)
    ]


def _placing(fields: "_Fields") -> Placing:
    def place(name: str) -> int | None:
        return fields.optional(name, lambda: fields.whole(name, 1, ENTRIES_MAX))

    def score(name: str) -> float | None:
        return fields.optional(name, lambda: fields.number(name))

    read = Placing(
        key=fields.whole("key"),
        place=place("place"),
        place_low=place("place_low"),
        place_high=place("place_high"),
        score=score("score"),
        score_low=score("score_low"),
        score_high=score("score_high"),
    )
    fields.end()
    return read


def _check_references(audit: Audit) -> None:
    """Raise AuditInvalid if entries and rounds do not fit together."""
    rounds = {each.number: each for each in audit.rounds}
    if len(rounds) < len(audit.rounds):
        raise AuditInvalid("two rounds have the same number")
    if sum(each.kind == RoundKind.FINAL for each in audit.rounds) > 1:
        raise AuditInvalid("there is more than one final")
    seen = set()
    for at, entry in enumerate(audit.entries, 1):
        if entry.round not in rounds:
            raise AuditInvalid(f"entry {at} belongs to round {entry.round}, which there is not")
        if (entry.batch is not None) != (rounds[entry.round].kind == RoundKind.FINAL):
            raise AuditInvalid(f"entry {at}: exactly the entries of a final have a batch")
        place = entry.round, entry.key, entry.batch
        if place in seen:
            raise AuditInvalid(f"entry {at}: its key occurs twice in the round or batch")
        seen.add(place)


class _Fields:
    """Takes the fields of an object one by one, each of its type; in the end none may be left."""

    def __init__(self, value: object, where: str) -> None:
        if not isinstance(value, Mapping):
            raise AuditInvalid(f"{where} is no object")
        self.where = where
        self._left = dict(value)

    def take(self, name: str) -> Any:
        if name not in self._left:
            raise AuditInvalid(f"{self.where} has no field {name}")
        return self._left.pop(name)

    def has(self, name: str) -> bool:
        return name in self._left

    def end(self) -> None:
        if self._left:
            name = str(next(iter(self._left)))[:TEXT_MAX]
            raise AuditInvalid(f"{self.where} has the unknown field {name!r}")

    def optional(self, name: str, read: Callable[[], _Value]) -> _Value | None:
        if name in self._left and self._left[name] is None:
            del self._left[name]
            return None
        return read()

    def text(self, name: str) -> str:
        value = self.take(name)
        # Printable: no half of a surrogate pair, which no UTF-8 can have, and no control characters
        if not (isinstance(value, str) and 0 < len(value) <= TEXT_MAX and value.isprintable()):
            self._refuse(name, f"no printable text of 1 to {TEXT_MAX} characters")
        return str(value)

    def content(self, name: str, most: int) -> str:
        value = self.take(name)
        try:
            fits = isinstance(value, str) and len(value.encode()) <= most
        except UnicodeEncodeError:  # half of a surrogate pair
            fits = False
        if not fits:
            self._refuse(name, f"no text of at most {most} bytes")
        return str(value)

    def sha256(self, name: str) -> str:
        value = self.take(name)
        if not (isinstance(value, str) and _SHA256.fullmatch(value)):
            self._refuse(name, "not 64 lower-case hexadecimal digits")
        return str(value)

    def whole(self, name: str, low: int = 0, high: int = _WHOLE_MAX) -> int:
        value = self.take(name)
        if type(value) is not int or not low <= value <= high:  # a bool is an int as well
            self._refuse(name, f"no whole number from {low} to {high}")
        return int(value)

    def number(self, name: str) -> float:
        value = self.take(name)
        if not _is_number(value):
            self._refuse(name, "no number of moderate size")
        return float(value)

    def numbers(self, name: str, most: int) -> list[float]:
        values = self.list(name, most)
        if not values or not all(map(_is_number, values)):
            self._refuse(name, "no list of numbers of moderate size")
        return [float(value) for value in values]

    def flag(self, name: str) -> bool:
        value = self.take(name)
        if not isinstance(value, bool):
            self._refuse(name, "neither true nor false")
        return bool(value)

    def one_of(self, name: str, kind: type[_Value]) -> _Value:
        value = self.take(name)
        try:
            return kind(value)  # type: ignore[call-arg]
        except ValueError:
            self._refuse(name, f"none of {', '.join(map(str, kind))}")  # type: ignore[call-overload]
            raise

    def list(self, name: str, most: int) -> list[Any]:
        value = self.take(name)
        if not isinstance(value, list | tuple) or len(value) > most:
            self._refuse(name, f"no list of at most {most} items")
        return list(value)

    def object(self, name: str) -> dict[str, Any]:
        value = self.take(name)
        if not isinstance(value, dict):
            self._refuse(name, "no object")
        if _depth(value) > DEPTH_MAX:
            self._refuse(name, f"nested more than {DEPTH_MAX} deep")
        try:
            digest_of(value)
        except (ValueError, TypeError):  # 1e999 is infinite; an object of Python may hold anything
            self._refuse(name, "no object of JSON")
        return dict(value)

    def _refuse(self, name: str, why: str) -> None:
        raise AuditInvalid(f"{self.where}: {name} is {why}")


def _is_number(value: object) -> bool:
    """Tell whether a value is a number whose squares and sums are finite as well."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= _WHOLE_MAX  # false for nan


def _depth(value: object) -> int:
    """Return how deep objects and lists are within each other, counted up to one too many."""
    depth, layer = 0, [value]
    while layer and depth <= DEPTH_MAX:
        inner = [each for each in layer if isinstance(each, dict | list)]
        layer = [
            item for each in inner for item in (each.values() if isinstance(each, dict) else each)
        ]
        depth += bool(inner)
    return depth


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object; two readers could take another one of two fields with the same name."""
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name occurs twice in one object")
    return found


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON")

"""What an organiser asks: a competition as a document, which TOML and JSON can hold.

The benchmark is one of ours with other settings of its scenario. When the competition opens, the
document is frozen: a change is a new version, with a name of its own.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime, timedelta
from enum import StrEnum
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_serializer,
)

from seamark.competitions import zones
from seamark.competitions.standings import Ties
from seamark.sandbox.printable_text import visible_text
from seamark.sim import registry
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import schema_extras

ROUNDS_MAX = 6
LENGTH_MAX = timedelta(days=3 * 366)  # from the first round to the last
NAME_MAX = 60  # [character], with the version
_SETTINGS_MAX = 200
_MESSAGES_MAX = 20


class DocumentInvalid(Exception):
    """The document breaks rules. `errors` has a sentence for each place, such as rounds.0.opens."""

    def __init__(self, errors: Mapping[str, str]) -> None:
        super().__init__(" ".join(f"{at}: {text}" for at, text in errors.items()))
        self.errors = dict(errors)


class RoundKind(StrEnum):
    """What a round is for. A document has no check: the reference entries make it of a draft."""

    CHECK = "check"
    PRACTICE = "practice"  # counts for nothing
    QUALIFICATION = "qualification"  # decides who is in the final, or the competition without one
    FINAL = "final"


class Carry(StrEnum):
    """Which entries of a team are carried from the qualification into the final."""

    BEST = "best"
    CHOSEN = "chosen"  # by the captain; without a choice the best


class Programs(StrEnum):
    """Who may read the programs that teams submit. Entrants agree on it."""

    HIDDEN = "hidden"  # their team alone
    ORGANISER = "organiser"
    PUBLIC = "public"  # everybody, those of the final, when it is decided


def _one_line(text: object) -> object:
    return " ".join(visible_text(text).split()) if isinstance(text, str) else text


def _paragraphs(text: object) -> object:
    """Return one text of a list of paragraphs: our TOML has no texts of several lines."""
    if isinstance(text, list) and all(isinstance(part, str) for part in text):
        text = "\n\n".join(text)
    return visible_text(text, keep="\n").strip() if isinstance(text, str) else text


def _zone(name: str) -> str:
    if name not in zones.zone_names():
        raise ValueError("must be a time zone such as Europe/Madrid or UTC")
    return name


Line = Annotated[str, BeforeValidator(_one_line)]
Paragraphs = Annotated[str, BeforeValidator(_paragraphs)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class Round(_Part):
    """A round that teams submit to.

    Attributes
    ----------
    quota
        Submissions of a team that may end in a result.
    trials
        Of each submission.
    board
        Whether everybody sees the scores before the round has ended.
    """

    kind: Literal[RoundKind.PRACTICE, RoundKind.QUALIFICATION]
    opens: datetime
    closes: datetime
    quota: int = Field(5, ge=1, le=100)
    trials: int = Field(8, ge=2, le=64)
    board: Literal["visible", "hidden"] = "visible"

    @field_serializer("opens", "closes")
    def _text(self, time: datetime) -> str:
        return _utc_text(time)


class Final(_Part):
    """The round that decides: all entries on the same new trials, which nobody can submit to.

    Attributes
    ----------
    opens
        When the entries that are carried into it are fixed.
    trials
        Of a batch. Batches are added until the ranks separate.
    batches
        At most.
    finalists
        Methods of a team, at most.
    """

    kind: Literal[RoundKind.FINAL]
    opens: datetime
    trials: int = Field(16, ge=4, le=64)
    batches: int = Field(4, ge=1, le=16)
    finalists: int = Field(1, ge=1, le=5)
    carry: Carry = Carry.BEST

    @field_serializer("opens")
    def _text(self, time: datetime) -> str:
        return _utc_text(time)


AnyRound = Annotated[Round | Final, Field(discriminator="kind")]


class CompetitionDocument(_Part):
    """A competition as its organiser writes it; complete, with all times in UTC.

    Attributes
    ----------
    name
        With the version, as in addresses: harbour-cup-v1.
    zone
        Time zone (IANA) of times without an offset, and of those that pages show.
    settings
        Of the scenario; the others are those of the benchmark. `score` is an expression that takes
        the place of the benchmark's score.
    """

    name: str = Field(
        pattern=r"^[a-z][a-z0-9]*(-[a-z0-9]+)*-v[1-9][0-9]{0,2}$", max_length=NAME_MAX
    )
    title: Line = Field(min_length=1, max_length=80)
    question: Line = Field("", max_length=200)
    rules: Paragraphs = Field("", max_length=8000)
    zone: Annotated[str, AfterValidator(_zone)] = "UTC"
    benchmark: str
    settings: dict[str, Any] = Field(default_factory=dict, max_length=_SETTINGS_MAX)
    programs: Programs = Programs.HIDDEN
    ties: Ties = Ties.EARLIER
    team_size: int = Field(5, ge=1, le=50)
    methods: int = Field(3, ge=1, le=10)
    rounds: tuple[AnyRound, ...] = Field(min_length=1, max_length=ROUNDS_MAX)

    @property
    def base(self) -> Benchmark:
        """The benchmark whose scenario it changes."""
        return registry.benchmark(self.benchmark)

    @property
    def final(self) -> Final | None:
        """The final, if there is one."""
        last = self.rounds[-1]
        return last if isinstance(last, Final) else None

    def round(self, number: int) -> Round | Final:
        """Return a round by its number, from 1; that of the check is the qualification."""
        return self.rounds[number - 1] if number else self.qualification

    @property
    def qualification(self) -> Round:
        """The round that decides who is in the final, or the competition without one."""
        return next(
            one
            for one in self.rounds
            if isinstance(one, Round) and one.kind is RoundKind.QUALIFICATION
        )

    def canonical(self) -> dict[str, Any]:
        """Return it as JSON values, all of them, as it is stored and its digest covers it."""
        return self.model_dump(mode="json")

    def digest(self) -> str:
        """Return the SHA-256 of the canonical JSON."""
        return digest_of(self.canonical())

    def scenario(self) -> Configuration:
        """Return the whole configuration; what solutions choose has its defaults.

        Raises
        ------
        DocumentInvalid
            With a sentence for each setting that is wrong, or that solutions choose.
        """
        fields = self.base.configuration.model_fields
        wrong = {
            f"settings.{name}": f"{name} is chosen by those who take part. Leave it out."
            for name in self.settings
            if name in fields and schema_extras(fields[name])["x-role"] == "solution"
        }
        try:
            config = self.base.read(self.settings)
        except ConfigurationInvalid as invalid:
            wrong |= {f"settings.{name}": text for name, text in invalid.errors.items()}
        if wrong:
            raise DocumentInvalid(wrong)
        return config

    def fixed(self) -> dict[str, Any]:
        """Return setting -> value of the whole scenario, which nobody who takes part may change."""
        fields = self.base.configuration.model_fields
        return {
            name: value
            for name, value in self.scenario().model_dump(mode="json").items()
            if schema_extras(fields[name])["x-role"] == "scenario"
        }

    @classmethod
    def restore(cls, values: Mapping[str, Any]) -> Self:
        """Return the document that `canonical` was stored from."""
        return cls.model_validate(values)


def digest_of(canonical: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a document's canonical JSON."""
    text = json.dumps(canonical, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def read(values: Mapping[str, Any]) -> CompetitionDocument:
    """Return the document in values as TOML or JSON gives them.

    The settings are checked by `scenario`: they may name a vehicle of the organiser's.

    Raises
    ------
    DocumentInvalid
        With a sentence for each place that is wrong.
    """
    try:
        document = CompetitionDocument.model_validate(dict(values))
    except ValidationError as error:
        found = error.errors(include_url=False, include_context=False)[:_MESSAGES_MAX]
        raise DocumentInvalid(dict(map(_message, found))) from None
    if document.benchmark not in registry.BENCHMARKS:
        known = ", ".join(registry.BENCHMARKS)
        raise DocumentInvalid({"benchmark": f"There is no such benchmark. Choose one of {known}."})
    utc, errors = _in_utc(document)
    errors |= dict(_broken_rules(utc)) if not errors else {}
    if errors:
        raise DocumentInvalid(errors)
    return utc


def _message(error: Any) -> tuple[str, str]:
    place = [str(part) for part in error["loc"] if part not in set(RoundKind)]
    text = str(error["msg"]).removeprefix("Value error, ")
    if error["type"] == "union_tag_invalid":
        place, text = [*place, "kind"], "Choose practice, qualification or final"
    if error["type"] == "extra_forbidden":
        text = "There is no such entry here. Check how it is spelled"
    if place == ["name"] and error["type"] == "string_pattern_mismatch":
        text = "Write lower-case letters, digits and hyphens, then the version: harbour-cup-v1"
    return ".".join(place) or "document", f"{text[:1].upper()}{text[1:]}."


def _in_utc(document: CompetitionDocument) -> tuple[CompetitionDocument, dict[str, str]]:
    """Return the document with all times in UTC, and what is wrong with them."""
    errors = dict[str, str]()
    rounds = list[Round | Final]()
    for number, one in enumerate(document.rounds):
        times = dict[str, datetime]()
        for name in ("opens", "closes"):
            if (time := getattr(one, name, None)) is not None:
                try:
                    times[name] = zones.to_utc(time, document.zone)
                except (ValueError, OverflowError) as error:
                    errors[f"rounds.{number}.{name}"] = str(error)
        rounds.append(one.model_copy(update=times))
    return document.model_copy(update={"rounds": tuple(rounds)}), errors


def _broken_rules(document: CompetitionDocument) -> Iterator[tuple[str, str]]:
    """Yield the places that break a rule between several entries, with a sentence for each."""
    kinds = [one.kind for one in document.rounds]
    if kinds.count(RoundKind.QUALIFICATION) != 1:
        yield "rounds", "Have one round of the kind qualification: it decides who goes on."
    if kinds.count(RoundKind.FINAL) > 1 or kinds != sorted(kinds, key=list(RoundKind).index):
        yield "rounds", "Practice comes before the qualification, and that before the one final."
    block = 1 if document.base.protocol is None else document.base.protocol.block
    for number, one in enumerate(document.rounds):
        if one.trials % block:
            at = f"rounds.{number}.trials"
            yield at, f"{document.benchmark} needs a multiple of {block} trials."
    yield from _broken_times(document.rounds)


def _broken_times(rounds: Sequence[Round | Final]) -> Iterator[tuple[str, str]]:
    for number, one in enumerate(rounds):
        if isinstance(one, Round) and one.closes <= one.opens:
            yield f"rounds.{number}.closes", "A round closes after it has opened."
    for number, (before, after) in enumerate(pairwise(rounds), start=1):
        if isinstance(before, Round) and after.opens < before.closes:
            yield f"rounds.{number}.opens", "It opens before the round above has closed."
    if rounds[-1].opens - rounds[0].opens > LENGTH_MAX:
        yield "rounds", "All rounds open within three years."


def _utc_text(time: datetime) -> str:
    return time.astimezone(UTC).isoformat().replace("+00:00", "Z")

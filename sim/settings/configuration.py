"""Configurations: flat, frozen, and every refusal a sentence that names the allowed range.

A benchmark declares its settings with `setting`. The same declaration gives the validation, the
JSON Schema that the form is generated from, and the text of the refusal, so they cannot disagree.
"""

import difflib
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Self

from annotated_types import Ge, Gt, Le, MaxLen, MinLen
from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.score_expression import MAX_LENGTH, ExpressionInvalid, check

Role = Literal["scenario", "solution"]
_COMMA = re.compile(r"\s*(-?\d+),(\d+)\s*")  # a number as half of the world writes it
_ADAPTERS: dict[object, TypeAdapter[Any]] = {
    annotation: TypeAdapter(annotation) for annotation in (bool, int, float, str, tuple[float, ...])
}
JSON_TYPES: dict[object, str] = {bool: "boolean", int: "integer", float: "number", str: "string"}


class ConfigurationInvalid(Exception):
    """Values that break the rules of a benchmark. The sentences are written for the user.

    Attributes
    ----------
    errors : dict of setting -> sentence
    """

    def __init__(self, errors: Mapping[str, str]) -> None:
        super().__init__(" ".join(errors.values()))
        self.errors = dict(errors)


class Configuration(BaseModel, ABC):
    """What all configurations have in common: nothing unknown, nothing infinite."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _plain_values(cls, value: object, info: ValidationInfo) -> object:
        field = cls.model_fields[_name(info)]
        if isinstance(value, bool) and field.annotation is not bool:
            raise ValueError("true and false are no numbers")
        return _listed(value) if "x-items" in schema_extras(field) else value

    @field_validator("*", mode="after")
    @classmethod
    def _within_choices_and_items(cls, value: object, info: ValidationInfo) -> object:
        if outside(value, cls.model_fields[_name(info)]):
            raise ValueError("outside the allowed values")
        return value

    @classmethod
    def applies(cls, name: str) -> Mapping[str, Sequence[str]]:
        """Return the choices of other settings beside which a setting does anything; {}: always."""
        only: Mapping[str, Sequence[str]] = schema_extras(cls.model_fields[name]).get(
            "x-applies", {}
        )
        return only

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> sentence for rules between several settings; none here."""
        return {}

    def ranking_errors(self) -> dict[str, str]:
        """Return setting -> sentence for what keeps this out of a ranked run; nothing here."""
        return {}

    def exact(self) -> bool:
        """Return whether every processor of x86-64 gives the same bits; so unless overridden."""
        return True

    def unused_columns(self) -> frozenset[str]:
        """Return the columns of the telemetry that stay 0 in every such run; none here."""
        return frozenset()

    def headline(self) -> Metric | None:
        """Return what the score is where it is not the benchmark's own headline; else None."""
        return None

    def custom_score(self) -> str:
        """Return the user's own expression over measures; empty without one."""
        return str(getattr(self, "score", ""))

    def _expression_errors(self) -> dict[str, str]:
        """Return setting -> sentence for expressions over names that cannot be worked out."""
        errors: dict[str, str] = {}
        for name, field in type(self).model_fields.items():
            text = getattr(self, name)
            if text and "x-names" in schema_extras(field):
                try:
                    check(text, schema_extras(field)["x-names"])
                except ExpressionInvalid as refusal:
                    errors[name] = f"{name} ({field.title}): {refusal}"
        return errors

    @abstractmethod
    def level_metric(self) -> Metric:
        """Return what a level's value is; its name is the value's in the metrics of a level."""

    @abstractmethod
    def level_values(self) -> tuple[float, ...]:
        """Return what each level sets, in order; a benchmark says what it is."""

    @abstractmethod
    def trial_duration_s(self) -> float:
        """Return the simulated length of a trial."""

    @classmethod
    def read(cls, values: Mapping[str, object]) -> Self:
        """Return the checked configuration.

        Raises
        ------
        ConfigurationInvalid
            With one sentence per wrong setting, all of them at once.
        """
        try:
            configuration = cls(**{str(key): value for key, value in values.items()})
        except ValidationError as refusal:
            raise ConfigurationInvalid(_sentences(cls, refusal)) from None
        errors = configuration.cross_field_errors() | configuration._expression_errors()
        if errors:
            raise ConfigurationInvalid(errors)
        return configuration

    @classmethod
    def restore(cls, values: Mapping[str, object]) -> Self:
        """Return the configuration of an earlier run, whatever today's rules accept.

        Values are converted to the type of their setting (a JSON list to a tuple) but not
        validated: one that is out of today's range stays as it was stored. A setting that no longer
        exists is ignored. A setting that did not exist then, or had another type, has its default.
        """
        known: dict[str, Any] = {
            name: _converted(values[name], field)
            for name, field in cls.model_fields.items()
            if name in values
        }
        return cls.model_construct(None, **known)


def setting(  # noqa: PLR0913  # one keyword per word of the schema
    default: object,
    *,
    title: str,
    help: str,
    group: str,
    role: Role,
    unit: str = "",
    low: float | None = None,
    above: float | None = None,
    high: float | None = None,
    choices: Mapping[str, str] | None = None,
    tag: str = "",
    source: str = "",
    advanced: bool = False,
    length: tuple[int, int] | None = None,
    names: Sequence[str] | None = None,
    applies: Mapping[str, Sequence[str]] | None = None,
) -> Any:  # pydantic's own Field says Any, so that it fits every annotation
    """Return one setting.

    Parameters
    ----------
    default
        The benchmark's value; a ranked run uses it for every scenario setting.
    title, help, group, unit
        What the form shows. `help` is one sentence.
    role
        "scenario" is what everybody has to share in a ranked run, "solution" is what competes.
    low, above, high
        Allowed range, `above` exclusive; of the items if the setting is a list.
    choices : mapping of value -> label
    tag
        Where the default comes from: S sourced, D derived, E estimated; `source` names the source
        or says why.
    length : (least, most) items of a list
    names
        Of what an expression may name; the setting is then the text of one, which may be empty.
    applies : mapping of another setting -> its values with which this one does anything
    """
    extra: dict[str, Any] = {"x-group": group, "x-role": role, "x-advanced": advanced}
    if unit:
        extra["x-unit"] = unit
    if tag:
        extra |= {"x-tag": tag, "x-source": source}
    if choices is not None:
        extra |= {"enum": list(choices), "x-labels": dict(choices)}
    if names is not None:
        extra["x-names"] = list(names)
    if applies is not None:
        extra["x-applies"] = dict(applies)
    bounds: dict[str, Any] = {}
    if names is not None:
        bounds = {"max_length": MAX_LENGTH}
    elif length is None:
        bounds = {"ge": low, "gt": above, "le": high}
    else:
        items = {"minimum": low, "exclusiveMinimum": above, "maximum": high}
        extra["x-items"] = {name: value for name, value in items.items() if value is not None}
        bounds = {"min_length": length[0], "max_length": length[1]}
    return Field(
        default,
        title=title,
        description=help,
        json_schema_extra=extra,
        validate_default=True,
        **bounds,
    )


def override(
    inherited: FieldInfo,
    default: object,
    *,
    help: str | None = None,
    **changes: str,
) -> Any:  # as `setting`
    """Return a setting of another configuration with a default and words of its own.

    Parameters
    ----------
    help
        What the form shows, if it is something else here.
    changes
        Group, tag, source or role, as `setting` takes them.
    """
    extra = schema_extras(inherited) | {f"x-{word}": value for word, value in changes.items()}
    description = help or inherited.description
    return FieldInfo.merge_field_infos(
        inherited, default=default, description=description, json_schema_extra=extra
    )


def schema_extras(field: FieldInfo) -> dict[str, Any]:
    """Return the x- words of a setting."""
    extra = field.json_schema_extra
    return dict(extra) if isinstance(extra, Mapping) else {}


def group_of(field: FieldInfo) -> str:
    """Return the group of a setting."""
    return str(schema_extras(field)["x-group"])


def allowed(field: FieldInfo) -> str:
    """Return the allowed values of a setting in words, such as "from 0 to 10 1/s"."""
    extra = schema_extras(field)
    if "enum" in extra:
        return "one of " + ", ".join(extra["enum"])
    if field.annotation is bool:
        return "true or false"
    if "x-names" in extra:
        return f"a text of at most {MAX_LENGTH} characters"
    unit = f" {extra['x-unit']}" if "x-unit" in extra else ""
    limits = _limits(field)
    items = extra.get("x-items")
    if items is not None:
        least, most = limits["minLength"], limits["maxLength"]
        count = f"{least}" if least == most else f"{least} to {most}"
        return f"a list of {count} numbers {_range(items, unit)}"
    number = "a whole number" if field.annotation is int else "a number"
    return f"{number} {_range(limits, unit)}".strip()


def _limits(field: FieldInfo) -> dict[str, Any]:
    """Return the limits of a setting by their JSON Schema keyword."""
    limits: dict[str, Any] = {}
    for constraint in field.metadata:
        match constraint:
            case Ge(ge=limit):
                limits["minimum"] = limit
            case Gt(gt=limit):
                limits["exclusiveMinimum"] = limit
            case Le(le=limit):
                limits["maximum"] = limit
            case MinLen(min_length=length):
                limits["minLength"] = length
            case MaxLen(max_length=length):
                limits["maxLength"] = length
    return limits


def _range(limits: Mapping[str, float], unit: str) -> str:
    low, above, high = (limits.get(k) for k in ("minimum", "exclusiveMinimum", "maximum"))
    start = f"above {above:g}" if above is not None else f"from {low:g}" if low is not None else ""
    if high is None:
        return f"{start}{unit}"
    return f"{start} to {high:g}{unit}" if low is not None else f"{start} up to {high:g}{unit}"


def outside(value: object, field: FieldInfo) -> bool:
    """Return whether a choice or an item of a list is none of the allowed ones."""
    extra = schema_extras(field)
    if "enum" in extra:
        return value not in extra["enum"]
    if "x-items" in extra and isinstance(value, tuple):
        return not all(_inside(item, extra["x-items"]) for item in value)
    return False


def _converted(value: object, field: FieldInfo) -> object:
    try:
        return _ADAPTERS[field.annotation].validate_python(value)
    except ValidationError:
        return field.default


def _name(info: ValidationInfo) -> str:
    if info.field_name is None:
        raise RuntimeError("a validator of settings was called outside a setting")
    return info.field_name


def _inside(item: float, limits: Mapping[str, float]) -> bool:
    return (
        math.isfinite(item)
        and item >= limits.get("minimum", -math.inf)
        and item > limits.get("exclusiveMinimum", -math.inf)
        and item <= limits.get("maximum", math.inf)
    )


def _listed(value: object) -> object:
    """Return text such as "0, 0.2", or a lone number, as a list; everything else as it is."""
    if isinstance(value, str):
        return [part.strip() for part in value.strip("[]() ").split(",") if part.strip()]
    return [value] if isinstance(value, int | float) else value


def _sentences(cls: type[Configuration], refusal: ValidationError) -> dict[str, str]:
    sentences: dict[str, str] = {}
    for error in refusal.errors(include_url=False):
        name = str(error["loc"][0]) if error["loc"] else "configuration"
        sentences.setdefault(name, _sentence(cls, name, error))
    return sentences


def _sentence(cls: type[Configuration], name: str, error: ErrorDetails) -> str:
    field = cls.model_fields.get(name)
    if field is None:
        near = difflib.get_close_matches(name, cls.model_fields, n=1)
        hint = (
            f"did you mean {near[0]}?" if near else "it knows: " + ", ".join(cls.model_fields) + "."
        )
        return f"{name} is not a setting of this benchmark; {hint}"
    got = error["input"]
    shown = f"{got:g}" if isinstance(got, float) else repr(got)
    comma = _COMMA.fullmatch(got) if isinstance(got, str) else None
    hint = f" Write it with a point: {comma[1]}.{comma[2]}." if comma else ""
    return f"{name} ({field.title}) must be {allowed(field)}, not {shown}.{hint}"


def schema_of(cls: type[Configuration], *, title: str, groups: Sequence[str]) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a configuration, one flat object, group by group."""
    order = sorted(cls.model_fields.items(), key=lambda item: groups.index(group_of(item[1])))
    properties = {name: _property(name, field) for name, field in order}
    for name, entry in properties.items():
        if applies := cls.applies(name):
            entry["x-applies"] = {other: list(values) for other, values in applies.items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


def _property(name: str, field: FieldInfo) -> dict[str, Any]:
    extra = schema_extras(field)
    default = field.default
    entry: dict[str, Any] = {"title": field.title or name, "description": field.description or ""}
    entry["default"] = list(default) if isinstance(default, tuple) else default
    limits = _limits(field)
    items = extra.pop("x-items", None)
    if items is not None:
        entry |= {"type": "array", "items": {"type": "number"} | items}
        entry["minItems"] = limits["minLength"]
        entry["maxItems"] = limits["maxLength"]
    else:
        entry |= {"type": JSON_TYPES[field.annotation]} | limits
    return entry | extra

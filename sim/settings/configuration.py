"""Configurations: flat, frozen, and validated with messages that name the allowed range."""

import difflib
import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, ClassVar, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    SerializerFunctionWrapHandler,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_serializer,
)
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from seamark.sim.metrics.metric import Metric
from seamark.sim.metrics.score_expression import ExpressionInvalid, check
from seamark.sim.settings.own_files import ADVICE, LIBRARIES
from seamark.sim.settings.refusal import ConfigurationInvalid
from seamark.sim.settings.setting import (
    allowed_values,
    group_of,
    is_outside,
    property_of,
    schema_extras,
)

UNUSED = "{} is not a setting of this benchmark; leave it out."
_MESSAGES_MAX = 20  # each unknown setting is compared with all known ones, and may list them
_DECIMAL_COMMA = re.compile(r"\s*(-?\d+),(\d+)\s*")
_ADAPTERS: dict[object, TypeAdapter[Any]] = {
    annotation: TypeAdapter(annotation) for annotation in (bool, int, float, str, tuple[float, ...])
}


class Configuration(BaseModel, ABC):
    """Base of all configurations: no unknown setting, no infinite number."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    # Groups of inherited settings that have no meaning here: nobody can set them, and they are not
    # part of what is stored.
    unused_groups: ClassVar[frozenset[str]] = frozenset()

    @classmethod
    def settings(cls) -> dict[str, FieldInfo]:
        """Return name -> declaration of the settings, without those of unused groups."""
        fields = cls.model_fields.items()
        return {name: field for name, field in fields if group_of(field) not in cls.unused_groups}

    @model_serializer(mode="wrap")
    def _without_unused(self, serialise: SerializerFunctionWrapHandler) -> dict[str, Any]:
        values: dict[str, Any] = serialise(self)
        unstored = self.unstored_groups()
        known = type(self).settings()
        return {
            name: value
            for name, value in values.items()
            if name in known and group_of(known[name]) not in unstored
        }

    @field_validator("*", mode="before")
    @classmethod
    def _without_conversion_of_booleans(cls, value: object, info: ValidationInfo) -> object:
        field = cls.model_fields[_name(info)]
        if isinstance(value, bool) and field.annotation is not bool:
            raise ValueError("true and false are not numbers")
        return _listed(value) if "x-items" in schema_extras(field) else value

    @field_validator("*", mode="after")
    @classmethod
    def _within_choices_and_items(cls, value: object, info: ValidationInfo) -> object:
        name = _name(info)
        if is_outside(value, cls.model_fields[name]) and not cls.accepts(name, value):
            raise ValueError("not one of the allowed values")
        return value

    @classmethod
    def accepts(cls, name: str, value: object) -> bool:
        """Return whether a setting may have a value that is not one of its choices.

        Here that is the file of a user's that this process knows.
        """
        return name in LIBRARIES and LIBRARIES[name].is_known(value)

    @classmethod
    def hint(cls, name: str, value: object) -> str:
        """Return a sentence to add where a value is refused: where a user's file can be used."""
        return ADVICE[name] if name in LIBRARIES and LIBRARIES[name].is_meant(value) else ""

    @classmethod
    def preset(cls, name: str, value: object) -> Mapping[str, object]:
        """Return settings that come with a value that is not one of the choices; none here."""
        return {}

    @classmethod
    def applies(cls, name: str) -> Mapping[str, Sequence[str]]:
        """Return the values of other settings with which a setting has an effect; {}: always."""
        extras = schema_extras(cls.model_fields[name])
        conditions: Mapping[str, Sequence[str]] = extras.get("x-applies", {})
        return conditions

    def cross_field_errors(self) -> dict[str, str]:
        """Return setting -> message for rules between several settings; none here."""
        return {}

    def ranking_errors(self) -> dict[str, str]:
        """Return setting -> message for what a ranked run does not allow; nothing here."""
        return {}

    def exact(self) -> bool:
        """Return whether every x86-64 processor gives the same bits; True unless overridden."""
        return True

    def unused_columns(self) -> frozenset[str]:
        """Return the columns of the telemetry that stay 0 in every such run; none here."""
        return frozenset()

    def headline(self) -> Metric | None:
        """Return what the score is, if not the benchmark's own headline; else None."""
        return None

    def for_trial(self, trial: int) -> Self:
        """Return the configuration of one trial; the same in all trials unless overridden."""
        return self

    def for_program(self) -> dict[str, Any]:
        """Return the settings that a program is given; all unless overridden."""
        return self.model_dump()

    def level_names(self) -> tuple[str, ...]:
        """Return a short name for each level; empty if its value and unit say enough."""
        return ()

    def images_per_start(self, level: int) -> int:
        """Return after how many images the tracker of a level is started again; 0: never."""
        return 0

    def cameras_of_program(self) -> tuple[str, ...]:
        """Return the cameras whose images a controller is given; none unless overridden."""
        return ()

    def unstored_groups(self) -> frozenset[str]:
        """Return groups of settings that are not stored because they are off; none here.

        For what comes to a benchmark that has results: without it, a configuration stays as it was.
        """
        return frozenset()

    def custom_score(self) -> str:
        """Return the user's own expression over metrics; empty without one."""
        return str(getattr(self, "score", ""))

    def _expression_errors(self) -> dict[str, str]:
        """Return setting -> message for invalid expressions."""
        errors: dict[str, str] = {}
        for name, field in type(self).model_fields.items():
            text = getattr(self, name)
            if text and "x-names" in schema_extras(field):
                try:
                    check(text, schema_extras(field)["x-names"])
                except ExpressionInvalid as error:
                    errors[name] = f"{name} ({field.title}): {error}"
        return errors

    @abstractmethod
    def level_metric(self) -> Metric:
        """Return what varies from level to level; its name is a key of a level's metrics."""

    @abstractmethod
    def level_values(self) -> tuple[float, ...]:
        """Return the value of `level_metric` at each level, in order."""

    def levels_in_order(self) -> bool:
        """Return whether the levels run as listed; True unless overridden."""
        return True

    @abstractmethod
    def trial_duration_s(self) -> float:
        """Return the simulated duration of a trial."""

    @abstractmethod
    def telemetry_shape(self) -> tuple[int, int]:
        """Return how many rows and columns of telemetry a trial has."""

    @classmethod
    def read(cls, values: Mapping[str, object]) -> Self:
        """Return the validated configuration.

        Raises
        ------
        ConfigurationInvalid
            With one message per wrong setting, all of them at once.
        """
        unused = cls.model_fields.keys() - cls.settings().keys()
        if wrong := {name: UNUSED.format(name) for name in values if name in unused}:
            raise ConfigurationInvalid(wrong)
        try:
            configuration = cls(**{str(key): value for key, value in values.items()})
        except ValidationError as error:
            raise ConfigurationInvalid(_messages(cls, error)) from None
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
            for name, field in cls.settings().items()
            if name in values
        }
        return cls.model_construct(None, **known)


def _converted(value: object, field: FieldInfo) -> object:
    try:
        return _ADAPTERS[field.annotation].validate_python(value)
    except ValidationError:
        return field.default


def _name(info: ValidationInfo) -> str:
    if info.field_name is None:
        raise RuntimeError("a validator of settings was called outside a setting")
    return info.field_name


def _listed(value: object) -> object:
    """Return a text such as "0, 0.2", or a single number, as a list; anything else unchanged."""
    if isinstance(value, str):
        return [part.strip() for part in value.strip("[]() ").split(",") if part.strip()]
    return [value] if isinstance(value, int | float) else value


def _messages(cls: type[Configuration], invalid: ValidationError) -> dict[str, str]:
    messages: dict[str, str] = {}
    for error in invalid.errors(include_url=False)[:_MESSAGES_MAX]:
        name = str(error["loc"][0]) if error["loc"] else "configuration"
        messages.setdefault(name, _message(cls, name, error))
    return messages


def _message(cls: type[Configuration], name: str, error: ErrorDetails) -> str:
    field = cls.settings().get(name)
    if field is None:
        near = difflib.get_close_matches(name, cls.settings(), n=1)
        known = f"the settings are: {', '.join(cls.settings())}."
        hint = f"did you mean {near[0]}?" if near else known
        return f"{name} is not a setting of this benchmark; {hint}"
    value = error["input"]
    shown = f"{value:g}" if isinstance(value, float) else repr(value)
    comma = _DECIMAL_COMMA.fullmatch(value) if isinstance(value, str) else None
    hint = f" Use a decimal point: {comma[1]}.{comma[2]}." if comma else cls.hint(name, value)
    return f"{name} ({field.title}) must be {allowed_values(field)}, not {shown}.{hint}"


def schema_of(cls: type[Configuration], *, title: str, groups: Sequence[str]) -> dict[str, Any]:
    """Return the JSON Schema (2020-12) of a configuration, one flat object, group by group."""
    properties = {name: dict(entry) for name, entry in _properties(cls, tuple(groups)).items()}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "type": "object",
        "additionalProperties": False,
        "properties": properties,
    }


@cache
def _properties(cls: type[Configuration], groups: tuple[str, ...]) -> dict[str, dict[str, Any]]:
    """Return setting -> its entry; made once, as the pages with a form ask for it several times."""
    order = sorted(cls.settings().items(), key=lambda item: groups.index(group_of(item[1])))
    properties = {name: property_of(name, field) for name, field in order}
    for name, entry in properties.items():
        if applies := cls.applies(name):
            entry["x-applies"] = {other: list(values) for other, values in applies.items()}
    return properties

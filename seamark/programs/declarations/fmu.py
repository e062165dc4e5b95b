"""Parameters of an FMU: those of its model description, with start, min, max and unit.

Not those that its mapping file connects to settings. A model with more than `COUNT_MAX` keeps the
start values of the others.
"""

import math
from collections.abc import Mapping

from seamark.programs import parameters
from seamark.programs.declarations.declared import Declared
from seamark.programs.parameters import DeclarationInvalid, Parameter
from seamark.sandbox.languages.fmu.inside import description
from seamark.sandbox.languages.fmu.inside.description import Unusable, Variable

_VARIABILITIES = ("fixed", "tunable")
_WHOLE = ("Int8", "Int16", "Int32", "Int64", "UInt8", "UInt16", "UInt32", "UInt64")


def read(archive: bytes, filename: str) -> Declared:
    """Return the parameters of the model; nothing if it cannot be read, which the box reports."""
    declarations = Declared()
    try:
        model = description.read(archive)
        mapped = model.mapping().get("parameters", {})
    except (Unusable, ValueError):
        return declarations
    for variable in model.of("parameter"):
        if variable.name in mapped or len(declarations.parameters) >= parameters.COUNT_MAX:
            continue
        one = _parameter(variable)
        if one is not None and all(one.name != other.name for other in declarations.parameters):
            declarations.parameters.append(one)
    return declarations


def _parameter(variable: Variable) -> Parameter | None:
    """Return the variable as a parameter; None if it is not one number that may be set."""
    given = variable.attributes
    if variable.count != 1 or given.get("variability", "tunable") not in _VARIABILITIES:
        return None
    default = _start(variable.type, given.get("start", ""))
    if default is None:
        return None
    try:
        return Parameter(
            name=variable.name,
            default=default,
            low=_limit(given, "min"),
            high=_limit(given, "max"),
            unit=parameters.clean(given.get("unit", ""), parameters.UNIT_MAX),
            description=parameters.clean(given.get("description", ""), parameters.DESCRIPTION_MAX),
        )
    except DeclarationInvalid:
        return None


def _start(kind: str, text: str) -> parameters.Value | None:
    if kind == "Boolean":
        return text in ("true", "1") if text in ("true", "false", "1", "0") else None
    number = _number(text)
    if number is None or kind not in (*_WHOLE, "Float32", "Float64"):
        return None
    return int(number) if kind in _WHOLE else number


def _limit(given: Mapping[str, str], name: str) -> float | None:
    number = _number(given.get(name, ""))
    return None if number is None or abs(number) > parameters.VALUE_MAX else number


def _number(text: str) -> float | None:
    try:
        number = float(text)
    except ValueError:
        return None
    return number if math.isfinite(number) else None

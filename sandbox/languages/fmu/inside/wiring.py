"""Connects an FMU's variables to observation, command and configuration: by name or mapping."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ...inside.port_names import (
    Span,
    command_spans,
    observation_names,
    observation_spans,
)
from ...inside.wire import command_limits, command_names
from .description import Description, Unusable, Variable

NUMBERS = ("Float64", "Float32", "Int32", "Boolean")  # types of variables that can be connected


class Input(NamedTuple):
    """A variable that is set from each observation."""

    variable: Variable
    span: Span


class Constant(NamedTuple):
    """A variable that is set once, before each level."""

    variable: Variable
    value: float


class Output(NamedTuple):
    """A variable that is read for the command."""

    variable: Variable
    span: Span


class Wiring(NamedTuple):
    """All connections of one FMU."""

    inputs: list[Input]
    constants: list[Constant]
    outputs: list[Output]
    fixed: dict[int, float]  # constant numbers of the command
    command: Sequence[str]  # the names of its numbers
    limits: Sequence[float]  # the largest magnitude of each


def wired(description: Description, layout: dict[str, Any], config: Mapping[str, object]) -> Wiring:
    """Return the connections; Unusable with the names on both sides if some are missing."""
    mapping = description.mapping()
    inputs, constants = _inputs(description, mapping.get("inputs", {}), layout, config)
    constants += _parameters(description, mapping.get("parameters", {}), config)
    names = command_names(layout)
    outputs, fixed = _outputs(description, mapping.get("outputs", {}), names)
    return Wiring(inputs, constants, outputs, fixed, names, command_limits(layout))


def _inputs(
    description: Description,
    mapping: dict[str, object],
    layout: dict[str, Any],
    config: Mapping[str, object],
) -> tuple[list[Input], list[Constant]]:
    spans = observation_spans(layout)
    inputs, constants, unknown = [], [], []
    for variable in description.of("input"):
        source = mapping.get(variable.name, variable.name)
        if isinstance(source, (int, float)):
            constants.append(Constant(_number(variable), float(source)))
        elif source in spans:
            span = spans[str(source)]
            inputs.append(Input(_number(variable, span.size), span))
        elif isinstance(value := config.get(str(source)), (int, float)):
            constants.append(Constant(_number(variable), float(value)))
        else:
            unknown.append(variable.name)
    _all_known(mapping, description, "inputs")
    if unknown:
        raise Unusable(
            f"The FMU has inputs that no observation has: {', '.join(unknown)}. Name them as these "
            f"or map them to these: {observation_names(layout)}."
        )
    return inputs, constants


def _parameters(
    description: Description, mapping: dict[str, object], config: Mapping[str, object]
) -> list[Constant]:
    """Return the parameters that are named as keys of the configuration, or mapped to one."""
    _all_known(mapping, description, "parameters")
    constants = []
    for variable in description.of("parameter"):
        source = mapping.get(variable.name, variable.name)
        value = source if isinstance(source, (int, float)) else config.get(str(source))
        if isinstance(value, (int, float)):
            constants.append(Constant(_number(variable), float(value)))
        elif variable.name in mapping:
            raise Unusable(
                f"The parameter {variable.name} is mapped to {source}, which is not a number."
            )
    return constants


def _outputs(
    description: Description, mapping: dict[str, object], wanted: Sequence[str]
) -> tuple[list[Output], dict[int, float]]:
    spans = command_spans(wanted)
    names = {variable.name: variable.name for variable in description.of("output")}
    fixed = {}
    for name, source in mapping.items():
        if name not in spans:
            raise Unusable(f"The mapping has an output {name}; there are {', '.join(wanted)}.")
        if isinstance(source, (int, float)):
            fixed[spans[name].offset] = float(source)
        elif source not in description.variables:
            missing = f"{source}, to which {name} is mapped"
            raise Unusable(_missing(description, missing, wanted))
        else:
            names[name] = str(source)
    outputs = [
        Output(_number(description.variables[source], spans[name].size), spans[name])
        for name, source in names.items()
        if name in spans
    ]
    given = {span.offset + i for _, span in outputs for i in range(span.size)} | set(fixed)
    lacking = [wanted[i] for i in (0, 1) if i not in given]  # the others may be 0
    if lacking:
        raise Unusable(_missing(description, " and ".join(lacking), wanted))
    return outputs, fixed


def _missing(description: Description, what: str, wanted: Sequence[str]) -> str:
    has = ", ".join(variable.name for variable in description.of("output")) or "none"
    return (
        f"The FMU has no output {what}. Its outputs are: {has}; wanted are {', '.join(wanted)}, "
        "by these names or by a mapping."
    )


def _all_known(mapping: dict[str, object], description: Description, part: str) -> None:
    causality = part.removesuffix("s")
    has = [variable.name for variable in description.of(causality)]
    for name in mapping:
        if name not in has:
            raise Unusable(
                f"The mapping has {name}, which is no {causality} of the FMU. "
                f"Its {part} are: {', '.join(has) or 'none'}."
            )


def _number(variable: Variable, count: int = 1) -> Variable:
    """Return the variable if it can be connected to so many numbers."""
    if variable.type not in NUMBERS:
        raise Unusable(f"{variable.name} is not of a numeric type ({', '.join(NUMBERS)}).")
    if variable.count != count:
        raise Unusable(f"{variable.name} has {variable.count} numbers, not {count}.")
    return variable

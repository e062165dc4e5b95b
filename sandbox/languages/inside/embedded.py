"""Connects C as Embedded Coder writes it to seamark.h: by the names of its ports.

What is read is the text of the generated files: `MODEL_initialize(void)` and `MODEL_step(void)`,
the structures of inputs (ExtU...), outputs (ExtY...) and parameters (P_...), and their variables.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from .names import COMMAND, WHOLE_COMMAND, commanded, observed, shown

OBSERVATION = {  # the fields of seamark_observation that are numbers, 0 for one
    **{"t": 0, "dt": 0, "error": 3, "error_px": 2, "target_visible": 0, "target_age": 0},
    **{"velocity": 3, "velocity_valid": 0, "depth": 0, "altitude": 0, "attitude": 3, "rates": 3},
    "thrust": 8,
}
COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
FUNCTION = r"\bvoid\s+{name}\s*\(\s*void\s*\)"
STEP = re.compile(FUNCTION.format(name=r"(\w+)_step"))
OURS = re.compile(r"\bseamark_(step|tracker_start|tracker_update|detect)\b")
ANY_STEP = re.compile(r"\bvoid\s+(\w+)_step\s*\(")
BODY = r"struct\s*\w*\s*\{{([^{{}}]*)\}}\s*({type}\w*)\s*;"
TAGGED = r"struct\s+({type}\w*?)_?\s*\{{([^{{}}]*)\}}\s*;"
FIELD = re.compile(r"(\w+)\s+(\w+)\s*(?:\[\s*(\d+)\s*\])?\s*;")
INTERFACE = (
    "Generate it with the code interface packaging 'Nonreusable function': then it has "
    "MODEL_initialize(void), MODEL_step(void) and the structures of inputs and outputs."
)


class Unfit(Exception):
    """This is no code of a model, or its ports do not fit. The text is for its owner."""


class Port(NamedTuple):
    """One field of a structure."""

    access: str  # as C names it
    name: str
    size: int  # 0 if it is no vector


def looks_generated(text: str) -> bool:
    """Tell whether this may be the code of a model: it has a step function and none of ours."""
    return OURS.search(text) is None and ANY_STEP.search(text) is not None


def adapter(text: str, headers: Iterable[str]) -> str:
    """Return the C file that makes a controller of the model; Unfit with the names if it cannot."""
    plain = COMMENT.sub(" ", text)
    model = _model(plain)
    inputs, outputs = _ports(plain, "ExtU"), _ports(plain, "ExtY")
    step = [*_inputs(inputs), f"{model}_step();", *_outputs(outputs)]
    begin = [*_parameters(_ports(plain, "P_")), f"{model}_initialize();"]
    end = [f"{model}_terminate();"] if _has(plain, f"{model}_terminate") else []
    lines = [
        *(f'#include "{header}"' for header in headers),
        '#include "seamark.h"',
        "#include <math.h>",
        "extern void seamark_refuse(const char *sentence);",
        *_function("int seamark_init(void)", [*_constants(inputs), *begin, "return 0;"]),
        *_function(
            "void seamark_reset(const seamark_level *level)", ["(void)level;", *end, *begin]
        ),
        *_function(
            "int seamark_step(const seamark_observation *observation, seamark_command *command)",
            [*step, "return 0;"],
        ),
    ]
    return "\n".join(lines) + "\n"


def _model(text: str) -> str:
    names = [name for name in STEP.findall(text) if _has(text, f"{name}_initialize")]
    if names:
        return str(names[0])
    found = ANY_STEP.search(text)
    name = found[1] if found else "MODEL"
    raise Unfit(f"There is no {name}_step(void) with {name}_initialize(void). {INTERFACE}")


def _has(text: str, function: str) -> bool:
    return re.search(FUNCTION.format(name=re.escape(function)), text) is not None


def _ports(text: str, kind: str) -> list[Port]:
    """Return the fields of the variable whose type begins with `kind`; none if there is none."""
    structures = {name: body for body, name in re.findall(BODY.format(type=kind), text)}
    structures |= dict(re.findall(TAGGED.format(type=kind), text))
    for name, body in structures.items():
        variable = re.search(rf"\b{name}\s+(\w+)\s*(?:=[^;]*)?;", text)
        if variable:
            return [
                Port(f"{variable[1]}.{field}", field, int(size or 0))
                for _, field, size in FIELD.findall(body)
            ]
    return []


def _sources() -> Mapping[str, list[str]]:
    """Return for each name of an observation what C calls its numbers."""
    cells: list[str] = []
    for name, count in OBSERVATION.items():
        cells += [f"observation->{name}[{i}]" for i in range(count)] or [f"observation->{name}"]
    places = observed({"observation": list(OBSERVATION.items())})
    return {name: cells[at : at + size] for name, (at, size) in places.items()}


def _inputs(ports: list[Port]) -> Iterator[str]:
    known = _sources()
    for port in ports:
        if port.name in known:
            yield from _assigned(port, known[port.name])


def _assigned(port: Port, cells: list[str]) -> Iterator[str]:
    if (port.size or 1) != len(cells):
        raise Unfit(f"The input {port.name} has {port.size or 1} numbers, not {len(cells)}.")
    for index, cell in enumerate(cells):
        yield f"{port.access}{f'[{index}]' if port.size else ''} = {cell};"


def _constants(ports: list[Port]) -> Iterator[str]:
    """Inputs that no observation has must be numbers of the configuration, which is known later."""
    known = _sources()
    names = shown({"observation": list(OBSERVATION.items())})
    for port in ports:
        if port.name in known:
            continue
        sentence = (
            f"The input {port.name} is neither of an observation nor a number of the "
            f"configuration. An observation has {names}."
        )
        yield f'if (isnan(seamark_config_number("{port.name}", NAN)))'
        yield f'    seamark_refuse("{sentence[:480]}");'
        yield f'{port.access} = seamark_config_number("{port.name}", 0.0);'


def _parameters(ports: list[Port]) -> Iterator[str]:
    for port in ports:
        if not port.size:
            yield f'{port.access} = seamark_config_number("{port.name}", {port.access});'


def _outputs(ports: list[Port]) -> Iterator[str]:
    places = commanded()
    given: set[int] = set()
    for port in ports:
        if port.name not in places:
            continue
        at, size = places[port.name]
        if (port.size or 1) != size:
            raise Unfit(f"The output {port.name} has {port.size or 1} numbers, not {size}.")
        for index in range(size):
            element = f"[{index}]" if port.size else ""
            yield f"command->{COMMAND[at + index]} = {port.access}{element};"
            given.add(at + index)
    if not {0, 1} <= given:  # heave and yaw rate may be 0
        has = ", ".join(port.name for port in ports) or "none"
        raise Unfit(
            f"The model needs outputs surge and sway; it has: {has}. Wanted are "
            f"{', '.join(COMMAND)}, or {WHOLE_COMMAND} with all four."
        )


def _function(head: str, lines: Iterable[str]) -> list[str]:
    return [f"{head} {{", *(f"    {line}" for line in lines), "}"]

"""Parameters of a program in C, C++ or MATLAB: lines of its comments.

    // @parameter lookahead 0.5 [0, 5] (s) How far ahead the error is predicted
    %  @parameter use_current true

Name and default are required; range, unit and description are not. Written with a decimal point a
default is a number, without one a whole number.
"""

import re

from seamark.programs import parameters
from seamark.programs.declarations.declared import Declared, Place

MARK = "@parameter"
_LINE_MAX = 500  # [character]
_LINE = re.compile(r"^\s*(?://+|/\*+|\*+|%+|#+)[ \t]*@parameter\b(.*)$")
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_DECLARATION = re.compile(
    rf"\A\s++(?P<name>\w+)\s+(?P<default>{_NUMBER}|true|false)"
    rf"(?:\s*\[\s*(?P<low>{_NUMBER})?\s*,\s*(?P<high>{_NUMBER})?\s*\])?"
    r"(?:\s*\((?P<unit>[^()]*)\))?(?:\s+(?P<description>[^\s\[(].*))?\s*"
)
_FORM = (
    "Write a parameter as `@parameter name default [lowest, highest] (unit) description`, such as "
    "`@parameter gain 0.5 [0, 2] (1/s) Proportional gain`; only name and default are required."
)


def read(source: bytes, filename: str) -> Declared:
    """Return what the comments of a text declare."""
    declarations = Declared()
    for number, line in enumerate(source.decode("utf-8", "replace").splitlines(), 1):
        if MARK not in line:
            continue
        match = _LINE.match(line[:_LINE_MAX])
        if match is not None:
            _read_line(match[1].removesuffix("*/").rstrip(), declarations, Place(filename, number))
    return declarations


def _read_line(text: str, declarations: Declared, place: Place) -> None:
    match = _DECLARATION.fullmatch(text)
    if match is None:
        return declarations.refuse(place, _FORM)
    low, high = match["low"], match["high"]
    return declarations.add(
        place,
        match["name"],
        _default(match["default"]),
        low=None if low is None else float(low),
        high=None if high is None else float(high),
        unit=parameters.clean(match["unit"] or "", parameters.UNIT_MAX),
        description=parameters.clean(match["description"] or "", parameters.DESCRIPTION_MAX),
    )


def _default(text: str) -> parameters.Value:
    if text in ("true", "false"):
        return text == "true"
    whole = text.lstrip("+-").isdecimal() and len(text) < len(str(int(parameters.VALUE_MAX)))
    return int(text) if whole else float(text)

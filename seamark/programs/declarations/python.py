"""Parameters of a Python program: the literal `PARAMETERS` of its main file.

```python
PARAMETERS = {
    "lookahead": {"default": 0.5, "range": [0, 5], "unit": "s", "description": "..."},
    "use_current": True,
}
```
"""

import ast

from seamark.programs import parameters
from seamark.programs.declarations.declared import Declared, Place

NAME = "PARAMETERS"
KEYS = ("default", "range", "unit", "description")
_FORM = (
    f'{NAME} must be a literal such as {{"gain": 0.5}} or '
    '{"gain": {"default": 0.5, "range": [0, 2], "unit": "1/s", "description": "..."}}, with '
    "nothing to compute: it is read without running the program."
)


def read(source: bytes, filename: str) -> Declared:
    """Return what `PARAMETERS` declares; nothing if the file cannot be parsed."""
    declarations = Declared()
    if NAME.encode() not in source:  # so that other programs are not parsed a second time
        return declarations
    try:
        tree = ast.parse(source.decode("utf-8-sig"), filename=filename)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return declarations  # the linter has the message
    for node in tree.body:
        if (value := _assigned(node)) is not None:
            _read_literal(value, declarations, filename)
    return declarations


def _assigned(node: ast.stmt) -> ast.expr | None:
    """Return what a statement of the module assigns to `PARAMETERS`; None if it does not."""
    if isinstance(node, ast.Assign):
        targets: list[ast.expr] = node.targets
    elif isinstance(node, ast.AnnAssign):
        targets = [node.target]
    else:
        return None
    named = any(isinstance(target, ast.Name) and target.id == NAME for target in targets)
    return node.value if named else None


def _read_literal(value: ast.expr, declarations: Declared, file: str) -> None:
    if not isinstance(value, ast.Dict):
        return declarations.refuse(Place(file, value.lineno), _FORM)
    for key, part in zip(value.keys, value.values, strict=True):
        try:
            name = None if key is None else ast.literal_eval(key)
            declared = ast.literal_eval(part)
        except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
            name = None
        if not isinstance(name, str):
            declarations.refuse(Place(file, part.lineno), _FORM)
            continue
        _add(declarations, Place(file, part.lineno), name, declared)
    return None


def _add(declarations: Declared, place: Place, name: str, declared: object) -> None:
    if not isinstance(declared, dict):
        return declarations.add(place, name, declared)
    unknown = [str(key)[:40] for key in declared if key not in KEYS]
    if unknown or "default" not in declared:
        wrong = f"has no {unknown[0]}" if unknown else "needs a default"
        sentence = f"The parameter {name[:60]} {wrong}; it may have {', '.join(KEYS)}."
        return declarations.refuse(place, sentence)
    span = declared.get("range", (None, None))
    if not _is_range(span):
        sentence = f"The range of {name[:60]} must be [lowest, highest], such as [0, 5]."
        return declarations.refuse(place, sentence)
    return declarations.add(
        place,
        name,
        declared["default"],
        low=None if span[0] is None else float(span[0]),
        high=None if span[1] is None else float(span[1]),
        unit=parameters.clean(str(declared.get("unit", "")), parameters.UNIT_MAX),
        description=parameters.clean(
            str(declared.get("description", "")), parameters.DESCRIPTION_MAX
        ),
    )


def _is_range(span: object) -> bool:
    return (
        isinstance(span, list | tuple)
        and len(span) == 2
        and all(one is None or _is_number(one) for one in span)
    )


def _is_number(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= parameters.VALUE_MAX

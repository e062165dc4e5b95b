"""What a reader of declarations found."""

from dataclasses import dataclass, field
from typing import NamedTuple, TypedDict, Unpack, cast

from seamark.programs import parameters
from seamark.programs.diagnostics import Diagnostic
from seamark.programs.parameters import DeclarationInvalid, Parameter, Value


class Place(NamedTuple):
    """Where a declaration is."""

    file: str
    line: int  # from 1


class Details(TypedDict, total=False):
    """What a declaration may have beside name and default."""

    low: float | None
    high: float | None
    unit: str
    description: str


@dataclass(slots=True)
class Declared:
    """Parameters in the order of the source, and problems."""

    parameters: list[Parameter] = field(default_factory=list)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def add(self, place: Place, name: str, default: object, **more: Unpack[Details]) -> None:
        """Add a parameter, or the reason why it cannot be one."""
        if any(one.name == name for one in self.parameters):
            return self.refuse(place, f"The parameter {name} is declared twice.")
        if len(self.parameters) >= parameters.COUNT_MAX:
            return self.refuse(place, f"A program may declare {parameters.COUNT_MAX} parameters.")
        try:  # a default of another type is refused there
            self.parameters.append(Parameter(name=name, default=cast(Value, default), **more))
        except DeclarationInvalid as reason:
            self.refuse(place, str(reason))
        return None

    def refuse(self, place: Place, sentence: str) -> None:
        """Add a problem."""
        self.diagnostics.append(Diagnostic(sentence=sentence, file=place.file, line=place.line))

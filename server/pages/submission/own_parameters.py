"""The parameters of one's own program in the form: fields named `parameters.<name>`."""

from collections.abc import Mapping
from dataclasses import dataclass

from seamark.programs import configurations
from seamark.programs.parameters import KEY, Parameter
from seamark.programs.setting_values import label_of, text_of
from seamark.server.pages.benchmark import form_fields
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.submission.validation import UPLOAD
from seamark.sim.benchmarks.benchmark import Benchmark

_PREFIX = f"{KEY}."


@dataclass(frozen=True, slots=True)
class ParameterField:
    """One parameter, as the template shows it."""

    parameter: Parameter
    value: str
    error: str

    @property
    def help(self) -> str:
        """What it means, its range and its default."""
        range_of = form_fields.range_of(self.parameter.entry())
        parts = [
            self.parameter.description.rstrip(".") + "." if self.parameter.description else "",
            f"Range: {range_of}." if range_of else "",
            f"Default: {label_of(self.parameter.entry(), self.parameter.default)}.",
        ]
        return " ".join(part for part in parts if part)

    @property
    def field(self) -> str:
        """The name of the input."""
        return _PREFIX + self.parameter.name


def read(posted: Mapping[str, str]) -> dict[str, object]:
    """Return the parameters of a posted form, as an entry of the configuration.

    A built-in solution has none; an empty field means the default.
    """
    if posted.get("controller") != UPLOAD:
        return {}
    given = {
        name.removeprefix(_PREFIX): text.strip()
        for name, text in posted.items()
        if name.startswith(_PREFIX) and text.strip()
    }
    return {KEY: given} if given else {}


def fields(
    benchmark: Benchmark,
    program: StoredProgram | None,
    values: Mapping[str, object],
    errors: Mapping[str, str],
) -> list[ParameterField]:
    """Return the fields of the program that the form has; a script adds those of a new one."""
    if program is None:
        return []
    given = values.get(KEY)
    chosen = given if isinstance(given, Mapping) else {}
    declared = configurations.declared_in(benchmark, program.language, program.parameters)
    return [
        ParameterField(
            one, text_of(chosen.get(one.name, one.default)), errors.get(_PREFIX + one.name, "")
        )
        for one in declared
    ]

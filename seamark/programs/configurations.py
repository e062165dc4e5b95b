"""The configuration of a run: the settings of its benchmark and the parameters of its program."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from seamark.programs import parameters
from seamark.programs.parameters import Parameter, Value
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.settings.configuration import Configuration
from seamark.sim.settings.refusal import ConfigurationInvalid


@dataclass(frozen=True, slots=True)
class RunConfiguration:
    """A valid configuration."""

    settings: Configuration
    declared: tuple[Parameter, ...]  # by the program
    values: Mapping[str, Value]  # of `declared`

    def document(self, settings: Configuration | None = None) -> dict[str, Any]:
        """Return the configuration as it is stored, with other settings if some are given."""
        below = {parameters.KEY: dict(self.values)} if self.values else {}
        return (settings or self.settings).model_dump(mode="json") | below


def declared_in(
    benchmark: Benchmark, language: str, declared: Sequence[Parameter]
) -> tuple[Parameter, ...]:
    """Return the parameters that a program has in a benchmark (`parameters.of_benchmark`)."""
    fields = benchmark.configuration.model_fields
    return parameters.of_benchmark(declared, language, fields)


def read(
    benchmark: Benchmark, given: Mapping[str, Any], declared: Sequence[Parameter] = ()
) -> RunConfiguration:
    """Return the validated configuration.

    Parameters
    ----------
    given
        Setting -> value, and the values of parameters below `parameters.KEY` or beside the
        settings.
    declared
        What `declared_in` returns for the program.

    Raises
    ------
    ConfigurationInvalid
        With a sentence for each wrong setting or parameter, all at once.
    """
    sent, below = parameters.split(parameters.gathered(given, declared))
    errors: dict[str, str] = {}
    values: dict[str, Value] = {}
    try:
        values = parameters.read(declared, below)
    except ConfigurationInvalid as invalid:
        errors = invalid.errors
    try:
        settings = benchmark.read(sent)
    except ConfigurationInvalid as invalid:
        raise ConfigurationInvalid(invalid.errors | errors) from None
    if errors:
        raise ConfigurationInvalid(errors)
    return RunConfiguration(settings, tuple(declared), values)

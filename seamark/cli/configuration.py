"""Benchmarks and their configurations as options of the command line give them."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seamark.cli.extras import has_simulator
from seamark.failures import UsageRefused

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from seamark.programs.parameters import Parameter
    from seamark.programs.preparation import PreparedProgram
    from seamark.sim.benchmarks.benchmark import Benchmark
    from seamark.sim.settings.configuration import Configuration

RUN_KEYS = frozenset({"benchmark", "config", "controller", "seed", "trials", "kind", "title"})
BOOLEANS = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}


def benchmark_of(name: str) -> Benchmark:
    """Return a benchmark.

    Raises
    ------
    UsageRefused
        There is none of this name.
    """
    from seamark.sim import registry

    if name not in registry.BENCHMARKS:
        known = ", ".join(registry.BENCHMARKS)
        raise UsageRefused(f"There is no benchmark {name}. Available: {known}.")
    return registry.benchmark(name)


def configuration_of(name: str, file: Path | None, pairs: Sequence[str]) -> Configuration:
    """Return the validated configuration of a benchmark; see `read_settings`.

    Raises
    ------
    UsageRefused
        There is no such benchmark, or a setting is invalid.
    """
    from seamark.sim.settings.refusal import ConfigurationInvalid

    benchmark = benchmark_of(name)
    try:
        return benchmark.read(typed(with_files(read_settings(file, pairs)), benchmark.schema()))
    except ConfigurationInvalid as error:
        raise UsageRefused(str(error)) from None


def run_configuration_of(
    name: str, file: Path | None, pairs: Sequence[str], program: PreparedProgram | None
) -> dict[str, Any]:
    """Return the validated configuration of a run, with the parameters of its program.

    Raises
    ------
    UsageRefused
        There is no such benchmark, or a setting or parameter is invalid.
    """
    from seamark.programs import configurations
    from seamark.sim.settings.refusal import ConfigurationInvalid

    benchmark = benchmark_of(name)
    declared: Sequence[Parameter] = ()
    if program is not None:
        declared = configurations.declared_in(benchmark, program.language, program.parameters)
    try:
        given = typed(with_files(read_settings(file, pairs)), benchmark.schema())
        return configurations.read(benchmark, given, declared).document()
    except ConfigurationInvalid as error:
        raise UsageRefused(str(error)) from None


def read_settings(
    file: Path | None, pairs: Sequence[str], *, option: str = "--set"
) -> dict[str, Any]:
    """Return the settings of a TOML or JSON file, overridden by `key=value` pairs."""
    values = {} if file is None else _read_file(file)
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or not key.strip():
            raise UsageRefused(
                f"{option} {pair}: write it as key=value, for example {option} kp=0.5."
            )
        values[key.strip()] = text.strip()
    return values


def with_files(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return settings in which the user's own files are read: vehicle, record, target picture.

    Raises
    ------
    UsageRefused
        One of them cannot be read, or breaks a rule.
    """
    from seamark.sim.files.library import FileInvalid
    from seamark.sim.settings import own_files
    from seamark.sim.vehicles import own
    from seamark.sim.vehicles.reading import VehicleInvalid

    try:
        return own_files.resolved(settings)
    except VehicleInvalid as reason:
        path, more = settings[own.SETTING], len(reason.errors) - 1
        rest = f" {more} more: `seamark vehicle check {path}`." if more else ""
        raise UsageRefused(f"{path}: {reason.errors[0]}{rest}") from None
    except FileInvalid as reason:
        raise UsageRefused(str(reason)) from None


def taken_vehicle(settings: Mapping[str, Any]) -> tuple[dict[str, Any], Path | None]:
    """Return settings without the file of a user's own vehicle, and that file, to be uploaded."""
    # As `seamark.sim.vehicles.own` has them, which the client alone does not have.
    chosen = settings.get("vehicle")
    if not isinstance(chosen, str) or not chosen.endswith(".toml"):
        return dict(settings), None
    return {name: value for name, value in settings.items() if name != "vehicle"}, Path(chosen)


def _read_file(path: Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8")
        value = tomllib.loads(text) if path.suffix.lower() == ".toml" else json.loads(text)
    except OSError as error:
        raise UsageRefused(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, RecursionError) as error:
        raise UsageRefused(f"{path} is neither TOML (name it .toml) nor JSON: {error}.") from None
    if not isinstance(value, dict):
        raise UsageRefused(f"{path} must hold keys and values, not a {type(value).__name__}.")
    config = value.get("config")
    if isinstance(config, dict) and set(value) <= RUN_KEYS:  # the body of POST /runs
        return dict(config)
    return value


def typed(values: Mapping[str, Any], schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with strings converted to the numbers and lists of the schema.

    A string that cannot be converted stays as it is: the benchmark has the better message.
    """
    properties = schema["properties"]
    return {key: _convert(value, properties.get(key, {})) for key, value in values.items()}


def typed_if_known(benchmark: str, values: dict[str, Any]) -> dict[str, Any]:
    """Convert strings if this installation knows the benchmark; otherwise the server does."""
    if not has_simulator():
        return values
    from seamark.sim import registry

    if benchmark not in registry.BENCHMARKS:
        return values
    return typed(values, registry.benchmark(benchmark).schema())


def _convert(value: Any, field: Mapping[str, Any]) -> Any:
    if not isinstance(value, str):
        return value
    json_type = field.get("type")
    if json_type == "array":
        parts = [part.strip() for part in value.strip("[]() ").split(",") if part.strip()]
        return [_number(part) for part in parts]
    if json_type in ("number", "integer"):
        return _number(value)
    return BOOLEANS.get(value.lower(), value) if json_type == "boolean" else value


def _number(text: str) -> float | int | str:
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text

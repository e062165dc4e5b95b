"""What the command line says about a controller and its configuration, read and checked."""

from __future__ import annotations

import difflib
import json
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from seamark.failures import UsageRefused
from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sim import registry

if TYPE_CHECKING:
    from seamark.sim.settings.configuration import Configuration

ORDER_KEYS = frozenset({"benchmark", "config", "controller", "seed", "trials", "kind", "title"})


def choose(controller: str | None, benchmark: str) -> tuple[str, Path | None]:
    """Return the name of what takes part, and its file; None for what is built in.

    What is not said is the benchmark's first; a benchmark that is not known here may be a newer
    server's.

    Raises
    ------
    UsageRefused
        It is neither a file nor built in, or a file in a language that cannot be.
    """
    known = benchmark if benchmark in registry.BENCHMARKS else next(iter(registry.BENCHMARKS))
    entry = registry.benchmark(known)
    built_in = list(entry.built_in)
    if controller is None or controller in built_in:
        return controller or built_in[0], None
    path = Path(controller)
    if path.is_file():
        _check_language(path, entry.role)
        return controller, path
    near = difflib.get_close_matches(controller, built_in, n=1)
    hint = f" Did you mean {near[0]}?" if near else ""
    raise UsageRefused(
        f"{controller} is neither a file nor a built-in {entry.role} ({', '.join(built_in)}).{hint}"
    )


def _check_language(path: Path, role: str) -> None:
    name = language_of(path.name)
    if name is not None and role not in LANGUAGES[name].roles:
        able = ", ".join(each.label for each in LANGUAGES.values() if role in each.roles)
        raise UsageRefused(
            f"{path}: a {role} is written in {able}, not in {LANGUAGES[name].label}."
        )


def configuration_of(benchmark: str, file: Path | None, pairs: Sequence[str]) -> Configuration:
    """Return the checked configuration of a benchmark; see `read_settings`.

    Raises
    ------
    UsageRefused
        There is no such benchmark, or a setting is wrong.
    """
    from seamark.sim import registry
    from seamark.sim.settings.configuration import ConfigurationInvalid

    if benchmark not in registry.BENCHMARKS:
        known = ", ".join(registry.BENCHMARKS)
        raise UsageRefused(f"There is no benchmark {benchmark}. There are: {known}.")
    entry = registry.benchmark(benchmark)
    try:
        return entry.read(typed(read_settings(file, pairs), entry.schema()))
    except ConfigurationInvalid as wrong:
        raise UsageRefused(str(wrong)) from None


def read_settings(file: Path | None, pairs: Sequence[str]) -> dict[str, Any]:
    """Return the configuration of a TOML or JSON file with `key=value` pairs on top."""
    values = {} if file is None else _file(file)
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals or not key.strip():
            raise UsageRefused(f"--set {pair}: write it as key=value, for example --set kp=0.5.")
        values[key.strip()] = text.strip()
    return values


def _file(path: Path) -> dict[str, Any]:
    try:
        text = path.read_text(encoding="utf-8")
        value = tomllib.loads(text) if path.suffix.lower() == ".toml" else json.loads(text)
    except OSError as error:
        raise UsageRefused(f"{path} cannot be read: {error.strerror}.") from None
    except (ValueError, RecursionError) as error:
        raise UsageRefused(f"{path} is neither TOML (name it .toml) nor JSON: {error}.") from None
    if not isinstance(value, dict):
        raise UsageRefused(f"{path} must hold keys and values, not a {type(value).__name__}.")
    inner = value.get("config")
    if isinstance(inner, dict) and set(value) <= ORDER_KEYS:  # an order as POST /runs takes it
        return dict(inner)
    return value


def typed(values: Mapping[str, Any], schema: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with texts of the command line as the numbers and lists they mean.

    What cannot be converted stays a text: the benchmark's own check has the better sentence.
    """
    properties = schema["properties"]
    return {key: _convert(value, properties.get(key, {})) for key, value in values.items()}


def _convert(value: Any, field: Mapping[str, Any]) -> Any:
    if not isinstance(value, str):
        return value
    kind = field.get("type")
    if kind == "array":
        parts = [part.strip() for part in value.strip("[]() ").split(",") if part.strip()]
        return [_number(part) for part in parts]
    if kind in ("number", "integer"):
        return _number(value)
    if kind == "boolean":
        return {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}.get(
            value.lower(), value
        )
    return value


def _number(text: str) -> float | int | str:
    for convert in (int, float):
        try:
            return convert(text)
        except ValueError:
            continue
    return text

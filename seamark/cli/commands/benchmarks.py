"""`seamark benchmarks`: the benchmarks and their settings."""

from __future__ import annotations

from typing import Any

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option


@click.command()
@click.argument("name", required=False)
@json_option
def benchmarks(name: str | None, as_json: bool) -> None:
    """List the benchmarks, or the settings of the benchmark NAME.

    \b
    Examples:
      seamark benchmarks
      seamark benchmarks currents-v3
      seamark benchmarks currents-v3 --json
    """
    from seamark.cli.configuration import benchmark_of

    if name is None:
        _list_all(as_json=as_json)
        return
    entry = benchmark_of(name)
    schema = entry.schema()
    if as_json:
        print_json(schema)
        return
    click.echo(f"{name}: {schema['title']}\n")
    for key, field in schema["properties"].items():
        click.echo(f"  --set {key}={_text(field['default'])}")
        click.echo(f"      {field['title']}: {field['description']}{_range(field)}")
    click.echo(f"\nBuilt-in {entry.role}s: " + ", ".join(entry.built_in))


def _list_all(*, as_json: bool) -> None:
    from seamark.sim import registry

    entries = [registry.benchmark(name) for name in registry.BENCHMARKS]
    if as_json:
        print_json([{"name": b.name, "title": b.title, "summary": b.summary} for b in entries])
        return
    for benchmark in entries:
        click.echo(f"{benchmark.name}\n    {benchmark.title}\n    {benchmark.summary}")


def _text(value: object) -> str:
    if isinstance(value, list | tuple):
        return ",".join(f"{item:g}" for item in value)
    return str(value).lower() if isinstance(value, bool) else str(value)


def _range(field: dict[str, Any]) -> str:
    if "enum" in field:
        return f" One of {', '.join(str(choice) for choice in field['enum'])}."
    limits = field.get("items", field)
    low, high = limits.get("minimum"), limits.get("maximum")
    unit = f" {field['x-unit']}" if "x-unit" in field else ""
    if low is None or high is None:
        return f" [{unit.strip()}]" if unit else ""
    return f" From {low:g} to {high:g}{unit}."

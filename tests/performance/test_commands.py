"""The commands of `./run performance`: each has a module that can run, and a place in the docs."""

import ast
import re
from importlib.util import find_spec
from pathlib import Path

import pytest

from performance import ROOT, commands
from performance.__main__ import main
from performance.commands import ALL, MODULES, OTHERS, QUICK, TABLES, takes_arguments


def functions_of(name: str) -> dict[str, ast.FunctionDef]:
    spec = find_spec(MODULES[name])
    assert spec is not None
    tree = ast.parse(Path(spec.origin or "").read_text("utf-8"))
    return {one.name: one for one in tree.body if isinstance(one, ast.FunctionDef)}


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_measured_without_arguments(name: str) -> None:
    found = functions_of(name)
    measuring = found.get("table") or found["rows"]

    assert len(measuring.args.defaults) == len(measuring.args.args)


@pytest.mark.parametrize("name", MODULES)
def test_commands_with_arguments_and_no_others_have_a_main_that_takes_them(name: str) -> None:
    found = functions_of(name).get("main")

    assert (found is not None and len(found.args.args) == 1) == takes_arguments(name)


def test_no_name_stands_for_two_commands() -> None:
    assert not set(TABLES) & set(OTHERS)
    assert ALL not in MODULES
    assert set(QUICK) <= set(TABLES)


def test_the_help_says_something_about_each_command() -> None:
    lines = [line.split(maxsplit=1) for line in commands.described().splitlines()]
    described = {line[0]: line[1] for line in lines if len(line) == 2}

    assert set(described) == set(MODULES)
    assert all(len(summary) > 20 for summary in described.values())


@pytest.mark.parametrize("name", MODULES)
def test_the_guide_for_contributors_names_each_command(name: str) -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text("utf-8")

    assert re.search(rf"`(\./run )?(performance )?{name}( --page)?`", text)


def test_every_command_of_the_documentation_exists() -> None:
    files = [*ROOT.glob("*.md"), ROOT / "run", *(ROOT / "docs").glob("*.md")]
    named = {
        name
        for file in files
        for name in re.findall(
            r"(?:\./run|python -m)\s+performance[ \n]([a-z_]+)", file.read_text()
        )
    }

    assert len(named) > 20
    assert named <= {*MODULES, ALL}


def test_an_unknown_name_is_refused_before_anything_is_measured() -> None:
    assert main(["physics", "no_such_table"]) == 2
    assert main(["growth", "7"]) == 2

"""Every sample of the documentation: programs run, commands exist, data can be read."""

import json
import re
import shlex
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import click
import pytest

from performance.figures import tutorial
from seamark.cli.main import cli

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
START = ROOT / "templates" / "docs" / "start.html"
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILTERED = re.compile(r'{% filter code\("python"\)\|safe %}(.*?){% endfilter %}', re.DOTALL)
COMMAND = re.compile(r"(?:^|do )(?:\./run )?seamark ([^;\n]+)", re.MULTILINE)
SHORT = ("--set", "levels=0.1", "--set", "level_duration_s=2", "--set", "settle_s=1")


def _blocks(language: str) -> Iterator[tuple[str, str]]:
    for page in PAGES:
        for found, text in BLOCK.findall(page.read_text(encoding="utf-8")):
            if found == language:
                yield page.name, text


COMMANDS = [(page, line) for page, text in _blocks("") for line in COMMAND.findall(text)]
PROGRAMS = {
    **tutorial.programs(),
    "start page": unescape(FILTERED.findall(START.read_text(encoding="utf-8"))[0]),
    "README": next(text for page, text in _blocks("python") if page == "README.md"),
}


@pytest.mark.parametrize(("page", "line"), COMMANDS)
def test_a_command_in_the_documentation_has_these_options(page: str, line: str) -> None:
    words = shlex.split(line, comments=True)
    command: click.Command = cli
    while isinstance(command, click.Group) and words and words[0] in command.list_commands(_CTX):
        command = command.get_command(_CTX, words.pop(0)) or cli
    known = {option for parameter in command.params for option in parameter.opts} | {"--help"}

    assert command is not cli or "--help" in words
    assert {word.partition("=")[0] for word in words if word.startswith("--")} <= known


_CTX = click.Context(cli)


@pytest.mark.parametrize(("page", "text"), list(_blocks("python")))
def test_python_in_the_documentation_compiles(page: str, text: str) -> None:
    compile(text, page, "exec")


@pytest.mark.parametrize(("page", "text"), list(_blocks("json")))
def test_json_in_the_documentation_can_be_read(page: str, text: str) -> None:
    assert json.loads(text)


def test_the_tutorial_has_a_program_for_each_step() -> None:
    assert len(tutorial.programs()) == 3


@pytest.mark.slow
@pytest.mark.parametrize("title", PROGRAMS)
def test_a_controller_of_the_documentation_runs(title: str) -> None:
    ended = tutorial.run(PROGRAMS[title], *SHORT)

    assert len(ended.t) == 40  # 2 s at 20 Hz
    assert 0 < ended.score <= 100

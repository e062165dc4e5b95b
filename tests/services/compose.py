"""The Compose files, read as an engine reads them."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[2]


def read(name: str = "compose.yaml") -> dict[str, Any]:
    """Return a file with its merges applied."""
    content: dict[str, Any] = yaml.safe_load((ROOT / name).read_text("utf-8"))
    return content


def service(name: str, file: str = "compose.yaml") -> dict[str, Any]:
    """Return one service."""
    found: dict[str, Any] = read(file)["services"][name]
    return found


def command(words: list[str], variables: Mapping[str, str]) -> list[str]:
    """Return a command with ${VARIABLE:-default} and $$ replaced."""
    return [interpolated(word, variables) for word in words]


def interpolated(text: str, variables: Mapping[str, str]) -> str:
    """Return a text as Compose hands it to a container.

    Raises
    ------
    KeyError
        A variable without a default is not given.
    """

    def value(found: re.Match[str]) -> str:
        if found[0] == "$$":
            return "$"
        if found[1] in variables:
            return variables[found[1]]
        if found[2] is None:
            raise KeyError(found[1])
        return found[2]

    return re.sub(r"\$\$|\$\{(\w+)(?::-([^}]*)|:\?[^}]*)?\}", value, text)


def environment(words: Mapping[str, str], variables: Mapping[str, str]) -> dict[str, str]:
    """Return the environment of a container."""
    return {name: interpolated(str(text), variables) for name, text in words.items()}

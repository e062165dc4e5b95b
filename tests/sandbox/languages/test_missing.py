"""What `./run` installs for the languages is what a language itself says that it needs."""

from dataclasses import replace
from typing import Never

import pytest

from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.missing import missing, packages, sentence
from seamark.sandbox.outcome import SandboxBroken


def _not_installed() -> Never:
    raise SandboxBroken("/usr/bin/abacus is not installed")


def test_a_language_without_its_interpreter_names_its_packages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    abacus = replace(
        LANGUAGES["matlab"],
        name="abacus",
        label="Abacus (of beads)",
        runtime=_not_installed,
        debian_packages=("abacus", "beads"),
    )
    before = [one.name for one in missing()]

    monkeypatch.setitem(LANGUAGES, "abacus", abacus)
    found = [one for one in missing() if one.name not in before]

    assert found == [abacus]
    assert packages([abacus, abacus]) == "abacus beads"
    assert sentence(found) == "Unavailable programs: Abacus. Install: apt-get install abacus beads"

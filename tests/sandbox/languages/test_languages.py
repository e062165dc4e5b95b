"""What the registry of languages promises to its readers."""

import pytest

from seamark.sandbox.languages import LANGUAGES


@pytest.mark.parametrize(
    ("language", "package"),
    [("c", "gcc"), ("c++", "g++"), ("matlab", "octave"), ("fmu", "gcc"), ("executable", "gcc")],
)
def test_the_remedy_of_a_missing_language_names_its_own_package(
    language: str, package: str
) -> None:
    others = {"gcc", "g++", "octave"} - {package}

    words = LANGUAGES[language].remedy.split()

    assert package in words
    assert not others & set(words)


def test_a_language_without_packages_is_mended_by_the_set_up() -> None:
    without = [language for language in LANGUAGES.values() if not language.debian_packages]

    assert [language.name for language in without] == ["python"]
    assert all("./run" in language.remedy for language in without)

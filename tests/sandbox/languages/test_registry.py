"""Every language has all of its parts: this fails when one is forgotten."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

from seamark.sandbox.languages import (
    DEFAULT_LANGUAGE,
    LANGUAGES,
    editor_starters,
    language_of,
    role_refusal,
    starters,
)
from seamark.sandbox.languages.language import ALL_ROLES, CONTROLLER, Calls, Language
from tests.sandbox.languages.folders import folder_of

ROOT = Path(__file__).parents[3]
HOSTILE = ROOT / "tests" / "hostile"
PAGE = (ROOT / "docs" / "languages.md").read_text("utf-8")
each_language = pytest.mark.parametrize("language", LANGUAGES.values(), ids=lambda one: one.name)


def folder(language: Language) -> Path:
    return ROOT / "sandbox" / "languages" / folder_of(language)


@each_language
def test_its_label_is_its_own_and_on_the_page_of_languages(language: Language) -> None:
    labels = [other.label for other in LANGUAGES.values()]

    assert labels.count(language.label) == 1
    assert language.label.split(" (")[0].lower() in PAGE.lower()
    for suffix in filter(None, language.suffixes):
        assert f"`{suffix}`" in PAGE
    for main in language.archive_mains:
        assert f"`{main}`" in PAGE


@each_language
def test_its_suffixes_lead_to_it_and_to_no_other_language(language: Language) -> None:
    assert language.suffixes
    assert {language_of(f"program{suffix}") for suffix in language.suffixes} == {language.name}


@each_language
def test_all_its_calls_have_names(language: Language) -> None:
    assert all(getattr(language.calls, field.name) for field in fields(Calls))


@each_language
def test_its_files_are_in_its_own_folder_or_in_that_of_its_compiler(language: Language) -> None:
    own = {folder(language), folder(LANGUAGES[language.sample_compiler])}
    samples = [language.self_test, *language.starters, *language.conformance]

    paths = [path for one in samples for path in one.files.values()]

    assert all(path.is_file() for path in paths)
    assert all(any(path.resolve().is_relative_to(here) for here in own) for path in paths)


@each_language
def test_it_has_a_starter_named_after_what_is_uploaded(language: Language) -> None:
    starter = language.starter(CONTROLLER)

    assert starter is not None
    assert starters()[language.name] is starter
    assert bool(starter.build) is not (language_of(starter.upload_name) == language.name)


@each_language
def test_a_text_of_it_can_be_written_in_the_editor_for_each_role(language: Language) -> None:
    written = {role for role in ALL_ROLES if language.name in editor_starters(role)}

    assert written == (set(language.roles) if language.is_text else set())


@each_language
def test_it_has_a_conformance_program_for_each_role(language: Language) -> None:
    assert {sample.role for sample in language.conformance} == set(language.roles)


@each_language
def test_the_name_of_each_starter_is_that_of_an_archive_with_it(language: Language) -> None:
    names = {one.upload_name for one in language.starters if language_of(one.upload_name)}

    assert not language.archive_mains or names <= set(language.archive_mains)


@each_language
def test_it_has_hostile_programs_with_expectations(language: Language) -> None:
    family = folder_of(LANGUAGES[language.sample_compiler])

    assert (HOSTILE / f"{family}.toml").is_file()
    assert len([*(HOSTILE / family).iterdir()]) >= 20


@each_language
def test_what_a_host_lacks_for_it_can_be_installed(language: Language) -> None:
    commands = re.findall(r"apt-get install ([a-z0-9+ -]+)|(`\./run`)", language.remedy)

    assert commands
    assert set(language.debian_packages) <= set(language.remedy.split())


@each_language
def test_a_role_that_it_has_not_is_refused_with_the_languages_that_have_it(
    language: Language,
) -> None:
    for role in ALL_ROLES:
        refusal = role_refusal(language.name, role)

        assert bool(refusal) is (role not in language.roles)
        assert not refusal or LANGUAGES[DEFAULT_LANGUAGE].label in refusal


@each_language
def test_the_image_of_workers_has_its_packages(language: Language) -> None:
    words = (ROOT / "Dockerfile").read_text("utf-8").split()

    assert set(language.debian_packages) <= set(words)


def test_an_unknown_language_is_refused_by_its_name() -> None:
    assert "not in cobol" in role_refusal("cobol", CONTROLLER)


@pytest.mark.parametrize(
    ("language", "package"),
    [("c", "gcc"), ("c++", "g++"), ("matlab", "octave"), ("fmu", "gcc"), ("executable", "gcc")],
)
def test_the_remedy_of_a_missing_language_names_only_its_own_compiler(language, package) -> None:
    words = LANGUAGES[language].remedy.split()

    assert package in words
    assert not ({"gcc", "g++", "octave"} - {package}) & set(words)

"""Judges: pybtex reads BibTeX, PyYAML and the official JSON schema a CITATION.cff."""

import datetime
import json
from dataclasses import replace
from functools import cache
from importlib.metadata import distribution
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import jsonschema_rs
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pybtex.database import parse_string

from seamark.programs.licences import LICENCES
from seamark.sandbox.printable_text import visible_text
from seamark.server.runs.publication import badge, citations
from seamark.server.runs.publication.citations import Author, Citation

RUN = Citation(
    key="seamark-run-17",
    subject="run 17",
    author=Author(name="Jane Doe", affiliation="Institute of Currents"),
    title="Observer, first try",
    benchmark="currents-v2",
    address="https://seamark.example/p/17",
    published=datetime.date(2026, 11, 23),
    licence="MIT",
    is_software=True,
    note="Score 0.157 m/s (95 % interval 0.12 to 0.19).",
)
NAMES = [
    "Jane Doe",
    "Müller & Söhne",
    "Doe, Jane, and many others and {friends}",
    r"100% \TeX_user #1 ~^$ }{",
    "Łukasz Ђорђе 山田太郎 Ólafsdóttir",
    "van der Berg and Smith",
    '"quoted" @misc',
]
# Names and enumerations, as far as they concern a run, of what Zenodo takes: legacyrecord.json of
# zenodo/zenodo (upload_type, access_right, relation), licenses.csv of zenodo/zenodo-rdm (license).
_TEXT = {"type": "string", "minLength": 1}
ZENODO: dict[str, Any] = {
    "type": "object",
    "additionalProperties": False,
    "required": ["title", "upload_type", "description", "creators", "access_right", "license"],
    "properties": {
        "title": _TEXT,
        "upload_type": {"enum": ["publication", "dataset", "software", "other"]},
        "description": _TEXT,
        "creators": {
            "type": "array",
            "minItems": 1,
            "items": {
                "additionalProperties": False,
                "required": ["name"],
                "properties": {"name": _TEXT, "affiliation": _TEXT, "orcid": _TEXT, "gnd": _TEXT},
            },
        },
        "publication_date": {"type": "string", "format": "date"},
        "access_right": {"enum": ["open", "embargoed", "restricted", "closed"]},
        "license": {
            "enum": [
                *("mit", "bsd-3-clause", "apache-2.0", "mpl-2.0", "lgpl-3.0-or-later"),
                *("gpl-3.0-or-later", "eupl-1.2", "cc0-1.0", "notspecified"),
            ]
        },
        "keywords": {"type": "array", "items": _TEXT},
        "related_identifiers": {
            "type": "array",
            "items": {
                "required": ["identifier", "relation"],
                "properties": {
                    "identifier": {"type": "string", "pattern": "^https?://"},
                    "relation": {
                        "enum": ["isIdenticalTo", "isSupplementTo", "isAlternateIdentifier"]
                    },
                },
            },
        },
    },
}
TITLES = st.text(max_size=120).map(visible_text)


def read_bibtex(text: str) -> Any:
    (entry,) = parse_string(text, "bibtex").entries.values()
    return entry


def plain(tex: str) -> str:
    """Return a TeX text as a reader of a reference list sees it, by the rules of TeX alone."""
    names = {"textbackslash": "\\", "textbraceleft": "<<", "textbraceright": ">>"}
    names |= {"textasciitilde": "~", "textasciicircum": "^"}
    text = tex
    for name, character in names.items():
        text = text.replace(f"\\{name}{{}}", f"\0{ord(character[0])}.{len(character)}\0")
    for special in "&%$#_":
        text = text.replace(f"\\{special}", special)
    text = text.strip("{}")
    for name, character in names.items():
        shown = {"textbraceleft": "{", "textbraceright": "}"}.get(name, character)
        text = text.replace(f"\0{ord(character[0])}.{len(character)}\0", shown)
    return text


@cache
def schema() -> jsonschema_rs.Draft7Validator:
    path = "check_jsonschema/builtin_schemas/vendor/citation-file-format.json"
    text = Path(str(distribution("check-jsonschema").locate_file(path))).read_text("utf-8")
    return jsonschema_rs.Draft7Validator(json.loads(text))


@pytest.mark.parametrize("name", NAMES)
def test_bibtex_keeps_a_name_whole_whatever_characters_it_has(name: str) -> None:
    entry = read_bibtex(citations.bibtex(replace(RUN, author=Author(name=name))))

    (person,) = entry.persons["author"]
    assert plain(str(person)) == name


@pytest.mark.slow
@settings(max_examples=40, deadline=None)
@given(title=TITLES)
def test_bibtex_keeps_any_title(title: str) -> None:
    entry = read_bibtex(citations.bibtex(replace(RUN, title=title, note="")))

    words = " ".join(title.split())
    assert plain(entry.fields.get("title", "")) == words
    assert set(entry.fields) >= {"year", "month", "url", "howpublished"}


def test_bibtex_says_where_and_when_the_run_is_found() -> None:
    entry = read_bibtex(citations.bibtex(RUN))

    assert entry.type == "misc"
    assert entry.fields["url"] == "https://seamark.example/p/17"
    assert (entry.fields["year"], entry.fields["month"]) == ("2026", "November")
    assert r"95 \% interval" in entry.fields["note"]


@pytest.mark.parametrize("licence", [None, *LICENCES])
@pytest.mark.parametrize("name", [NAMES[0], NAMES[3], NAMES[4]])
def test_a_citation_file_is_valid_by_the_official_schema(name: str, licence: str | None) -> None:
    changed = replace(RUN, author=Author(name=name), licence=licence, is_software=bool(licence))

    read = yaml.safe_load(citations.cff(changed))

    read["date-released"] = str(read["date-released"])
    assert [error.message for error in schema().iter_errors(read)] == []
    assert read["authors"] == [{"name": name}]
    assert read.get("license") == licence
    assert read["type"] == ("software" if licence else "dataset")


@settings(max_examples=40, deadline=None)
@given(title=TITLES.filter(str.strip))
def test_a_citation_file_keeps_any_title(title: str) -> None:
    read = yaml.safe_load(citations.cff(replace(RUN, title=title)))

    assert read["title"] == title


@pytest.mark.parametrize("licence", [None, *LICENCES])
@pytest.mark.parametrize("is_software", [True, False])
def test_the_metadata_for_zenodo_are_valid_in_each_field(
    licence: str | None, is_software: bool
) -> None:
    run = replace(RUN, licence=licence, is_software=is_software)

    read = json.loads(citations.zenodo(run))

    validator = jsonschema_rs.Draft7Validator(ZENODO, validate_formats=True)
    assert [error.message for error in validator.iter_errors(read)] == []
    assert read["license"] == (licence or "notspecified").lower()  # else Zenodo takes CC BY 4.0
    assert read["creators"] == [{"name": "Jane Doe", "affiliation": "Institute of Currents"}]
    assert read["related_identifiers"][0]["identifier"] == RUN.address


def test_the_description_for_zenodo_is_escaped() -> None:
    read = json.loads(citations.zenodo(replace(RUN, note="<b>1 < 2</b>")))

    assert "&lt;b&gt;1 &lt; 2&lt;/b&gt;" in read["description"]


def test_the_licence_of_an_archive_says_what_is_granted_and_where_its_text_is() -> None:
    granted = citations.licence_file(RUN)
    none = citations.licence_file(replace(RUN, licence=None))
    results = citations.licence_file(replace(RUN, licence=None, is_software=False))

    assert "SPDX-License-Identifier: MIT\n" in granted
    assert "https://spdx.org/licenses/MIT.html" in granted
    assert "all rights are reserved" in none
    assert "results without a program" in results
    assert "SPDX" not in none + results


def test_an_archive_for_review_names_nobody() -> None:
    written = citations.files(replace(RUN, author=citations.ANONYMOUS))

    assert set(written) == {"CITATION.cff", "citation.bib", ".zenodo.json", "LICENSE"}
    assert all("Anonymous author" in text for text in written.values())
    assert not any("Jane" in text or "Institute" in text for text in written.values())


@settings(max_examples=40, deadline=None)
@given(texts=st.tuples(*[st.text(max_size=200).map(visible_text)] * 3))
def test_a_badge_is_a_small_picture_with_a_name_and_without_links(
    texts: tuple[str, str, str],
) -> None:
    text = badge.svg(*texts)

    root = ElementTree.fromstring(text)  # noqa: S314 - our own
    tags = {element.tag.partition("}")[2] for element in root.iter()}
    assert tags == {"svg", "title", "clipPath", "rect", "g", "text"}
    assert root.get("role") == "img"
    assert root.get("aria-label") == root[0].text
    assert len(text) < 4000
    assert "href" not in " ".join(key for element in root.iter() for key in element.keys())

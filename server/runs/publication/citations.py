"""How a published run is cited: BibTeX, CITATION.cff, and the metadata of an archive at Zenodo."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, date, datetime
from html import escape
from typing import Any

from seamark.server.runs.recomputation.verifications import Outcome, VerificationView
from seamark.server.runs.record.anonymity import NAME
from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.solutions import solution
from seamark.server.runs.showing.views import RunView

_KEYWORDS = ("underwater robotics", "benchmark", "station keeping", "simulation")
# Braces are written as commands: BibTeX counts them even behind a backslash.
_TEX = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "{": r"\textbraceleft{}",
        "}": r"\textbraceright{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
    }
    | {special: f"\\{special}" for special in "&%$#_"}
)
# Zenodo takes a deposit without a licence for one under CC BY 4.0, which nobody has granted. This
# is "License Not Specified" of its vocabulary; all of LICENCES are in it too, in lower case.
_NO_LICENCE_AT_ZENODO = "notspecified"
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")


@dataclass(frozen=True, slots=True, kw_only=True)
class Author:
    """Who is cited: a person or a group, whose name is never taken apart."""

    name: str
    affiliation: str = ""


ANONYMOUS = Author(name=NAME)


@dataclass(frozen=True, slots=True, kw_only=True)
class Citation:
    """What a citation says of a run, or of a competition."""

    key: str  # by which BibTeX knows it
    subject: str  # such as "run 12"
    author: Author
    title: str
    benchmark: str
    address: str  # permanent and absolute
    published: date
    licence: str | None
    is_software: bool  # the program is published too
    note: str

    @property
    def kind(self) -> str:
        """What it is, in one word."""
        return self.subject.partition(" ")[0]

    @property
    def abstract(self) -> str:
        """What it is, in a sentence or two."""
        subject = f"{self.subject[0].upper()}{self.subject[1:]}"
        return f"{subject} of the benchmark {self.benchmark} on Seamark. {self.note}"


def of_run(
    run: RunView, author: Author, *, address: str, result: str, mark: VerificationView | None
) -> Citation:
    """Return the citation of a public run.

    Parameters
    ----------
    result
        The score in words, with its unit.
    mark
        The newest verification, if there is one.
    """
    at = datetime.fromtimestamp(run.published_at or 0.0, UTC)
    return Citation(
        key=f"seamark-run-{run.id}",
        subject=f"run {run.id}",
        author=ANONYMOUS if run.anonymous else author,
        title=_title(run),
        benchmark=run.benchmark,
        address=address,
        published=at.date(),
        licence=run.licence,
        is_software=run.has_programs and run.program_public,
        note=" ".join(filter(None, (_kind(run), _score(run, result), _verified(mark)))),
    )


def bibtex(citation: Citation) -> str:
    """Return an entry for BibTeX and biblatex, in UTF-8."""
    fields = {
        "author": f"{{{_tex(citation.author.name)}}}",  # one name, whatever words it has
        "title": f"{{{_tex(citation.title)}}}",
        "year": str(citation.published.year),
        "month": _MONTHS[citation.published.month - 1],
        "howpublished": _tex(f"Seamark, benchmark {citation.benchmark}, {citation.subject}"),
        "url": citation.address,
        "note": _tex(citation.note),
    }
    lines = [
        f"  {name} = {value if name == 'month' else f'{{{value}}}'},"
        for name, value in fields.items()
        if value
    ]
    return "\n".join((f"@misc{{{citation.key},", *lines, "}", ""))


def cff(citation: Citation) -> str:
    """Return a CITATION.cff of version 1.2.0; its texts are JSON strings, which YAML has too."""
    values: dict[str, Any] = {
        "cff-version": "1.2.0",
        "message": f"If you use this {citation.kind}, please cite it with these metadata.",
        "type": "software" if citation.is_software else "dataset",
        "title": citation.title,
        "abstract": citation.abstract,
        "authors": [{"name": citation.author.name}],
        "date-released": citation.published.isoformat(),
        "keywords": list(_KEYWORDS),
        "url": citation.address,
    }
    if citation.licence is not None:
        values["license"] = citation.licence
    lines = (f"{name}: {json.dumps(value, ensure_ascii=False)}" for name, value in values.items())
    return "\n".join((*lines, ""))


def zenodo(citation: Citation) -> str:
    """Return a .zenodo.json: the metadata with which Zenodo shows an archive."""
    creator = {"name": citation.author.name}
    if citation.author.affiliation and citation.author != ANONYMOUS:
        creator["affiliation"] = citation.author.affiliation
    values: dict[str, Any] = {
        "title": citation.title,
        "upload_type": "software" if citation.is_software else "dataset",
        "description": f"<p>{escape(citation.abstract)}</p>",
        "creators": [creator],
        "publication_date": citation.published.isoformat(),
        "access_right": "open",
        "license": (citation.licence or _NO_LICENCE_AT_ZENODO).lower(),
        "keywords": list(_KEYWORDS),
        "related_identifiers": [
            {"identifier": citation.address, "relation": "isIdenticalTo"},
        ],
    }
    return json.dumps(values, indent=2, ensure_ascii=False) + "\n"


def licence_file(citation: Citation) -> str:
    """Return the LICENSE of an archive: by whom and how the program may be used."""
    if not citation.is_software:
        return "This archive has results without a program. No licence is granted for them here.\n"
    if citation.licence is None:
        return (
            "No licence is granted here for the program of this run: the files of the program may "
            "grant one.\nWithout one, all rights are reserved.\n"
        )
    year, name = citation.published.year, citation.author.name
    return (
        f"SPDX-FileCopyrightText: {year} {name}\nSPDX-License-Identifier: {citation.licence}\n\n"
        f"The program of this run is licensed under {citation.licence}. This file does not have "
        f"the text of the licence; it is at\nhttps://spdx.org/licenses/{citation.licence}.html\n"
    )


def files(citation: Citation) -> Mapping[str, str]:
    """Return name -> content of what makes an archive ready to be cited and deposited."""
    return {
        "CITATION.cff": cff(citation),
        "citation.bib": bibtex(citation),
        ".zenodo.json": zenodo(citation),
        "LICENSE": licence_file(citation),
    }


def _tex(text: str) -> str:
    return " ".join(text.split()).translate(_TEX)


def _title(run: RunView) -> str:
    name = run.method or run.title or f"{solution(run)} in {run.benchmark}"
    return " ".join(name.split())


def _kind(run: RunView) -> str:
    words = qualifier(run)
    return f"{words[0].upper()}{words[1:]}." if words else ""


def _score(run: RunView, result: str) -> str:
    if run.score is None:
        return ""
    interval = ""
    if run.score_low is not None and run.score_high is not None:
        interval = f" (95 % interval {run.score_low:.3g} to {run.score_high:.3g})"
    return f"{result}{interval}."


def _verified(mark: VerificationView | None) -> str:
    if mark is None or mark.outcome is not Outcome.AGREES:
        return ""
    on = datetime.fromtimestamp(mark.at, UTC).date()
    return f"Verified on fresh trials on {on} by Seamark {mark.version}, digest {mark.digest}."

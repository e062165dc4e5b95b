"""The history of a tuning as a CSV file: written after each candidate, read by --resume.

The first line is a comment with everything that decides what is tried. To resume is to ask the
method again and to give it the scores of the file: so the rest of the search is the same as without
the interruption.
"""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from seamark.drafts import replace_file
from seamark.failures import UsageRefused
from seamark.tuning.candidates import Candidate, Evaluated
from seamark.tuning.search_space import Value

_COLUMNS = ("candidate", "score", "failure")  # then the tuned parameters
_MARK = "# seamark tune "


@dataclass(frozen=True, slots=True, kw_only=True)
class _Row:
    texts: tuple[str, ...]  # of the values, in the order of the names
    ended: Evaluated


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


@dataclass(slots=True)
class History:
    """The candidates of a tuning so far, in a file if there is a path."""

    path: Path | None
    settings: Mapping[str, Any]  # JSON values: what decides which candidates are tried
    names: Sequence[str]  # of the tuned parameters
    _rows: dict[int, _Row] = field(default_factory=dict)

    def load(self) -> None:
        """Read the file.

        Raises
        ------
        UsageRefused
            It cannot be read, or belongs to another search.
        """
        if self.path is None or not self.path.exists():
            raise UsageRefused(f"There is no history {self.path} to resume.")
        try:
            first, _, table = self.path.read_text(encoding="utf-8").partition("\n")
            settings = json.loads(first.removeprefix(_MARK))
            lines = list(csv.reader(io.StringIO(table)))[1:]
            self._rows = {int(line[0]): _read_row(line) for line in lines}
        except (OSError, ValueError, IndexError) as error:
            raise UsageRefused(f"{self.path} is not the history of a tuning: {error}.") from None
        differing = [name for name, value in self.settings.items() if settings.get(name) != value]
        if differing:
            raise UsageRefused(
                f"{self.path} was made with another {differing[0].replace('_', ' ')}. Repeat the "
                "options of the first call, or choose another --out."
            )

    def ended(self, candidate: Candidate) -> Evaluated | None:
        """Return how a candidate ended earlier; None if it did not."""
        row = self._rows.get(candidate.number)
        if row is None:
            return None
        if row.texts != self._texts(candidate):
            raise UsageRefused(
                f"{self.path}: candidate {candidate.number} has other values than this version of "
                "the method proposes, so that the search cannot be resumed. Choose another --out."
            )
        return row.ended

    def add(self, candidate: Candidate, evaluated: Evaluated) -> None:
        """Note how a candidate ended."""
        self._rows[candidate.number] = _Row(texts=self._texts(candidate), ended=evaluated)
        self.save()

    def _texts(self, candidate: Candidate) -> tuple[str, ...]:
        return tuple(_text(candidate.values[name]) for name in self.names)

    def save(self) -> None:
        """Write the file; raises UsageRefused."""
        if self.path is None:
            return
        table = io.StringIO()
        table.write(_MARK + json.dumps(self.settings) + "\n")
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow((*_COLUMNS, *self.names))
        for number, row in sorted(self._rows.items()):
            score = "" if row.ended.score is None else repr(row.ended.score)
            writer.writerow((number, score, row.ended.failure, *row.texts))
        try:
            replace_file(self.path, table.getvalue().encode())
        except OSError as error:
            raise UsageRefused(f"{self.path} cannot be written: {error.strerror}.") from None


def _read_row(line: Sequence[str]) -> _Row:
    score, failure = line[1:3]
    ended = Evaluated(score=float(score) if score else None, failure=failure)
    return _Row(texts=tuple(line[3:]), ended=ended)

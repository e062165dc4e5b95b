"""Full-text search in the documentation: an SQLite index (FTS5) in the memory of each process.

A section ranks by the words of the question that it has, rare words before common ones (BM25). A
word of a heading says what a section is about, so it counts more than one of the text.
"""

import math
import re
import sqlite3
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from threading import Lock

from markupsafe import escape

from seamark.server.pages.docs.articles import Section

QUERY_MAX = 100
RESULTS_MAX = 20
# Letters and digits, and what C++ and p@5 have.
_WORD = re.compile(r"[\w+@]+")
_PREFIX_FROM = 3  # letters of a word that also finds longer words
_STOP_WORDS = frozenset(
    "a about an and any are as at be by can could do does for from get gets give given has have "
    "how i if in into is it its may me much my need of on one or our should so than that the "
    "their them then there they this to two use used using want was we what when where which who "
    "whom whose why will with would you your".split()
)
# Words, or beginnings of words, that those who ask and those who answer use for the same
_SAME: tuple[frozenset[str], ...] = (
    frozenset({"comput", "calculat", "formula"}),
    frozenset({"fail", "error", "crash"}),
    frozenset({"see", "visible", "privacy", "private"}),
    frozenset({"package", "librar"}),
    frozenset({"student", "pupil"}),
    frozenset({"teach", "class"}),
    frozenset({"limit", "allowed", "quota"}),
    frozenset({"cite", "citation", "bibtex"}),
    frozenset({"shortcut", "keyboard"}),
    frozenset({"tutorial", "guide"}),
)
_SYNONYM = 0.5  # of the weight of the word itself
_PAIR = 0.7  # of the weight of a word: two words of the query side by side
_HEADING, _PAGE = 4.0, 1.0  # weights beside that of a word in the text
_LAST_PAGE = 0.6  # weight of the last page, which is for operators, beside the first
_MISSING = 1.5  # exponent: a section with half of the words counts for a third
_COMMON = 0.2  # the least weight of a word, even if most sections have it
# Around what was found, until the rest is escaped
_START, _END = "\x02", "\x03"
_TEXT = "SELECT rowid, -bm25(part, 0, 0, 0, 1) FROM part WHERE part MATCH ?"
_TITLE = "SELECT rowid, 0.0 FROM part WHERE part MATCH ?"
_SNIPPET = """
    SELECT snippet(part, 3, char(2), char(3), '…', 24) FROM part WHERE part MATCH ? AND rowid = ?
"""


@dataclass(frozen=True, slots=True)
class SearchResult:
    """A part of a page that has words of the query."""

    address: str
    page: str
    heading: str
    excerpt: str  # HTML, with marks


@dataclass(frozen=True, slots=True)
class _Part:
    """What is known of a row of the index."""

    address: str
    page: str
    heading: str
    place: float  # weight of its page
    page_share: float  # weight of a word of the page's title
    heading_share: float  # weight of a word of the heading


class SearchIndex:
    """The parts of all pages; thread-safe."""

    def __init__(self, pages: Iterable[tuple[str, str, Iterable[Section]]]) -> None:
        """Index pages: address, title and parts of each; those for newcomers first."""
        self._lock = Lock()
        self._database = sqlite3.connect(":memory:", check_same_thread=False)
        self._database.execute(
            "CREATE VIRTUAL TABLE part USING fts5"
            "(address UNINDEXED, page, heading, text, "
            "tokenize=\"porter unicode61 tokenchars '+@'\")"
        )
        self._parts: dict[int, _Part] = {}
        listed = list(pages)
        for number, (address, title, sections) in enumerate(listed):
            place = 1.0 - (1.0 - _LAST_PAGE) * number / len(listed)
            for one in sections:
                self._add(address + (f"#{one.anchor}" if one.anchor else ""), title, one, place)

    def _add(self, address: str, title: str, one: Section, place: float) -> None:
        row = len(self._parts) + 1
        of_page = (_PAGE if one.heading else _HEADING) / math.sqrt(_length(title))
        of_heading = _HEADING / math.sqrt(_length(one.heading))
        self._parts[row] = _Part(address, title, one.heading, place, of_page, of_heading)
        self._database.execute(
            "INSERT INTO part (rowid, address, page, heading, text) VALUES (?, ?, ?, ?, ?)",
            (row, address, title, one.heading, one.text),
        )

    def find(self, query: str) -> list[SearchResult]:
        """Return the parts that answer a question or have its words, the best first.

        A word finds longer words that begin with it. Words such as "how" and "the" count only in a
        query that has no others.
        """
        asked = dict.fromkeys(_WORD.findall(query[:QUERY_MAX].lower()))
        words = [word for word in asked if word not in _STOP_WORDS] or list(asked)
        if not words:
            return []
        patterns = [list(_patterns(word)) for word in words]
        pairs = [f'"{first} {second}"' for first, second in pairwise(words)]
        with self._lock:
            best = self._best(patterns, pairs)
            every = " OR ".join(pattern for each in patterns for pattern, _weight in each)
            return [self._result(row, every) for row in best[:RESULTS_MAX]]

    def _best(self, patterns: list[list[tuple[str, float]]], pairs: list[str]) -> list[int]:
        scores: dict[int, float] = {}
        counts: dict[int, int] = {}
        for alternatives in patterns:
            for row, score in self._scores(alternatives).items():
                scores[row] = scores.get(row, 0.0) + score
                counts[row] = counts.get(row, 0) + 1
        for pair in pairs:
            for row, score in self._scores_of(pair).items():
                scores[row] += _PAIR * score

        def key(row: int) -> tuple[float, int]:
            share = counts[row] / len(patterns)
            return -scores[row] * share**_MISSING * self._parts[row].place, row

        return sorted(scores, key=key)

    def _scores(self, alternatives: list[tuple[str, float]]) -> dict[int, float]:
        """Return row -> score for one word: that of the alternative that fits best."""
        best: dict[int, float] = {}
        for pattern, weight in alternatives:
            for row, score in self._scores_of(pattern).items():
                best[row] = max(best.get(row, 0.0), weight * score)
        return best

    def _scores_of(self, pattern: str) -> dict[int, float]:
        in_text = self._matches(_TEXT, "text", pattern)
        in_heading = self._matches(_TITLE, "heading", pattern)
        in_page = self._matches(_TITLE, "page", pattern)
        rows = in_text.keys() | in_heading.keys() | in_page.keys()
        rare = math.log((len(self._parts) - len(rows) + 0.5) / (len(rows) + 0.5))
        weight = max(rare, _COMMON)
        scores = {}
        for row in rows:
            part = self._parts[row]
            title = part.page_share * (row in in_page)
            title += part.heading_share * (row in in_heading)
            scores[row] = in_text.get(row, 0.0) + weight * title
        return scores

    def _matches(self, statement: str, column: str, pattern: str) -> dict[int, float]:
        return dict(self._database.execute(statement, (f"{{{column}}} : {pattern}",)).fetchall())

    def _result(self, row: int, every: str) -> SearchResult:
        part = self._parts[row]
        (text,) = self._database.execute(_SNIPPET, (every, row)).fetchone()
        return SearchResult(part.address, part.page, part.heading, _marked(text))


def _patterns(word: str) -> Iterator[tuple[str, float]]:
    """Yield what to search for a word, with weights: the word, then others of the same meaning."""
    # In quotes no word is an operator.
    yield f'"{word}"' + ("*" if len(word) >= _PREFIX_FROM else ""), 1.0
    for same in _SAME:
        own = {other for other in same if _is(word, other)}
        if own:
            yield from ((f'"{other}"*', _SYNONYM) for other in sorted(same - own))


def _is(word: str, beginning: str) -> bool:
    return word.startswith(beginning) if len(beginning) > _PREFIX_FROM else word == beginning


def _length(title: str) -> int:
    """Return the number of words of a title that say something; at least 1."""
    return max(1, sum(word not in _STOP_WORDS for word in _WORD.findall(title.lower())))


def _marked(text: str) -> str:
    return str(escape(text)).replace(_START, "<mark>").replace(_END, "</mark>")

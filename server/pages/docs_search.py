"""Full-text search in the documentation: an SQLite index (FTS5) in the memory of each process."""

import re
import sqlite3
from collections.abc import Iterable
from dataclasses import dataclass
from threading import Lock

from markupsafe import escape

from seamark.server.pages.docs_articles import Section

QUERY_MAX = 100
FOUND_MAX = 20
_WORD = re.compile(r"\w+")
# Around what was found, until the rest is escaped. A word in the title of a page or section counts
# more than one in its text.
_START, _END = "\x02", "\x03"
_FIND = """
    SELECT address, page, heading, snippet(part, 3, char(2), char(3), '…', 24)
    FROM part WHERE part MATCH ? ORDER BY bm25(part, 0, 6, 8, 1) LIMIT ?
"""


@dataclass(frozen=True, slots=True)
class Found:
    """A part of a page that has all words of the query."""

    address: str
    page: str
    heading: str
    excerpt: str  # HTML, with marks


class SearchIndex:
    """The parts of all pages; thread-safe."""

    def __init__(self, pages: Iterable[tuple[str, str, Iterable[Section]]]) -> None:
        """Index pages: address, title and parts of each."""
        self._lock = Lock()
        self._database = sqlite3.connect(":memory:", check_same_thread=False)
        self._database.execute(
            "CREATE VIRTUAL TABLE part USING fts5"
            "(address UNINDEXED, page, heading, text, tokenize='porter unicode61')"
        )
        rows = (
            (address + (f"#{one.anchor}" if one.anchor else ""), title, one.heading, one.text)
            for address, title, sections in pages
            for one in sections
        )
        self._database.executemany("INSERT INTO part VALUES (?, ?, ?, ?)", rows)

    def find(self, query: str) -> list[Found]:
        """Return the parts with all words of the query, or words that begin so; the best first."""
        words = _WORD.findall(query[:QUERY_MAX])
        if not words:
            return []
        match = " ".join(f'"{word}"*' for word in words)  # quoted: no word is an operator
        with self._lock:
            rows = self._database.execute(_FIND, (match, FOUND_MAX)).fetchall()
        return [
            Found(address, page, heading, _marked(text)) for address, page, heading, text in rows
        ]


def _marked(text: str) -> str:
    return str(escape(text)).replace(_START, "<mark>").replace(_END, "</mark>")

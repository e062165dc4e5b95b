"""The text of a documentation page: anchors, sections, code, its parts for the search."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html import unescape
from html.parser import HTMLParser

from markupsafe import escape
from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name
from pygments.lexers.special import TextLexer
from pygments.util import ClassNotFound

CONTENTS_FROM = 4  # sections: a shorter page needs no list of them
_HEADING = re.compile(r"<h([23])(?: id=\"([^\"]*)\")?>(.*?)</h\1>", re.DOTALL)
_COMMAND = re.compile(r"(?<![\w./-])seamark [a-z]")
_TAG = re.compile(r"<[^<>]+>")
# Classes only: the content security policy forbids inline styles. The colours are in pages.css.
_FORMATTER = HtmlFormatter(nowrap=True)


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a page below one heading, as text."""

    anchor: str  # empty: before the first heading
    heading: str
    text: str


def anchor_of(heading: str) -> str:
    """Return the anchor that common Markdown viewers give a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def code_block(text: str, language: str = "") -> str:
    """Return a block of code as HTML; of an unknown or no language without colours."""
    try:
        lexer = get_lexer_by_name(language) if language else TextLexer()
    except ClassNotFound:
        lexer = TextLexer()
    shown = highlight(text.rstrip("\n"), lexer, _FORMATTER).rstrip("\n")  # escaped by Pygments
    return (
        f'<div class="code"><pre tabindex="0"><code>{shown}</code></pre>'
        '<button class="button small" type="button" data-copy-code>'
        "<span data-label>Copy</span></button></div>\n"
    )


def article(html: str) -> str:
    """Return a page with an anchor on each heading, after a list of its sections if it is long."""
    sections: dict[str, str] = {}

    def anchored(heading: re.Match[str]) -> str:
        level, anchor, inside = heading.groups()
        words = _TAG.sub("", inside)
        anchor = anchor or anchor_of(unescape(words))
        if level == "2":
            sections[anchor] = words
        return f'<h{level} id="{anchor}">{inside}</h{level}>'

    shown = _HEADING.sub(anchored, html)
    return _contents(sections) + shown


def with_way_to_install(html: str, address: str) -> str:
    """Return a page, with a link to `address` if it names commands and does not link there yet.

    Without an address it is the page about installing.
    """
    if not address or not _COMMAND.search(html) or f'href="{address}"' in html:
        return html
    return (
        f'{html}<p class="small muted">Commands that start with <code>seamark</code> run on your '
        f'own computer: <a href="{escape(address)}">install the command line</a>.</p>'
    )


def sections_of(html: str) -> Iterator[Section]:
    """Return the parts of a page that `article` has made, without its list of sections."""
    reader = _Reader()
    reader.feed(html.partition("</details><!--contents-->")[2] or html)
    reader.close()
    for part in reader.parts:
        heading, text = (" ".join("".join(words).split()) for words in (part.heading, part.text))
        if text or heading:
            yield Section(part.anchor, heading, text)


def _contents(sections: dict[str, str]) -> str:
    if len(sections) < CONTENTS_FROM:
        return ""
    entries = "".join(
        f'<li><a href="#{escape(anchor)}">{words}</a></li>' for anchor, words in sections.items()
    )
    return (
        '<details class="page-contents"><summary>On this page</summary>'
        f"<ul>{entries}</ul></details><!--contents-->"
    )


@dataclass
class _Part:
    anchor: str = ""
    heading: list[str] = field(default_factory=list)
    text: list[str] = field(default_factory=list)


class _Reader(HTMLParser):
    """Collects anchor, heading and text of each part; blocks are words apart."""

    def __init__(self) -> None:
        super().__init__()
        self.parts = [_Part()]
        self._in_heading = False
        self._in_button = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag in {"h2", "h3"}:
            self.parts.append(_Part(dict(attrs).get("id") or ""))
            self._in_heading = True
        self._in_button = tag == "button" or (self._in_button and tag == "span")

    def handle_endtag(self, tag: str) -> None:
        self._in_heading = self._in_heading and tag not in {"h2", "h3"}
        self._in_button = self._in_button and tag != "button"
        if tag not in {"code", "span", "a", "em", "strong", "sub", "sup"}:
            self.parts[-1].text.append(" ")

    def handle_data(self, data: str) -> None:
        if not self._in_button:
            part = self.parts[-1]
            (part.heading if self._in_heading else part.text).append(data)

"""The Markdown pages of docs/ as part of the site."""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any
from urllib.parse import urljoin

from markdown_it import MarkdownIt
from markdown_it.common.utils import escapeHtml
from markdown_it.renderer import RendererHTML
from markdown_it.token import Token

from seamark import server
from seamark.server.pages.docs.articles import anchor_of, code_block

FOLDER = Path(server.__file__).parents[1] / "docs"
# Suffix -> content type of files that a page may show or link to.
ATTACHED = {
    ".hpp": "text/plain; charset=utf-8",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".txt": "text/plain; charset=utf-8",
    ".webp": "image/webp",
}
BENCHMARKS = "benchmarks.md"  # a section for each benchmark
ADDRESS = "/docs/guides/"  # of the pages and of what they link to
_TITLE = re.compile(r"\A# (.+)\n")
_COMMENT = re.compile(r"<!--.*?-->\n?", re.DOTALL)  # marks between which a command writes
_LINK = re.compile(r'(href|src)="([^"]+)"')
_RELATIVE = re.compile(r'(href|src)="([^"#][^"]*)"')
_SECTION_HEADING = re.compile(r'<h2 id="([^"]+)">([^<]+)</h2>')


@lru_cache(maxsize=1)
def titles() -> Mapping[str, str]:
    """Return file name -> title of every page in docs/."""
    return {path.name: _title(path) for path in sorted(FOLDER.glob("*.md"))}


@lru_cache(maxsize=1)
def attachments() -> frozenset[str]:
    """Return the paths below docs/ of all figures and text files for pages."""
    paths = (path for path in FOLDER.rglob("*") if path.suffix in ATTACHED)
    return frozenset(path.relative_to(FOLDER).as_posix() for path in paths)


def attachment(name: str) -> tuple[bytes, str]:
    """Return content and content type of a path in `attachments`."""
    return (FOLDER / name).read_bytes(), ATTACHED[Path(name).suffix]


@lru_cache(maxsize=32)
def html(name: str) -> str:
    """Return a page in `titles` as HTML, without its title; its links work from any address.

    Raw HTML in a page is shown as text, comments are left out.
    """
    return _linked(name, str(_markdown().render(_TITLE.sub("", _text(name), count=1))))


@lru_cache(maxsize=32)
def markdown(text: str) -> str:
    """Return paragraphs in Markdown as HTML."""
    return str(_markdown().render(text))


@lru_cache(maxsize=32)
def section(name: str, title: str) -> tuple[str, Mapping[str, str]]:
    """Return a section of a page in `titles` as HTML, and anchor -> title of its subsections.

    Subsections become headings of the second level, and links work from any address. Without such
    a section both are empty.
    """
    _, _, after = f"\n{_text(name)}".partition(f"\n## {title}\n")
    inside = re.split(r"^## ", after, maxsplit=1, flags=re.MULTILINE)[0]
    shown = str(_markdown().render(re.sub(r"^##(#+ )", r"#\1", inside, flags=re.MULTILINE)))
    page = ADDRESS + name
    linked = _LINK.sub(lambda link: f'{link[1]}="{urljoin(page, link[2])}"', shown)
    return linked, dict(_SECTION_HEADING.findall(shown))


def _linked(name: str, shown: str) -> str:
    """Make the links to other pages absolute, and leave those within the page."""
    return _RELATIVE.sub(lambda link: f'{link[1]}="{urljoin(ADDRESS + name, link[2])}"', shown)


@lru_cache(maxsize=32)
def folded(shown: str) -> Sequence[tuple[str, str, str]]:
    """Return anchor, title and HTML of each part of a `section` that has a heading."""
    parts = _SECTION_HEADING.split(shown)[1:]
    return list(zip(parts[::3], parts[1::3], parts[2::3], strict=True))


def _text(name: str) -> str:
    return _COMMENT.sub("", (FOLDER / name).read_text(encoding="utf-8"))


def _title(path: Path) -> str:
    with path.open(encoding="utf-8") as file:
        return file.readline().removeprefix("# ").strip()


@lru_cache(maxsize=1)
def _markdown() -> MarkdownIt:
    markdown = MarkdownIt("commonmark", {"html": False}).enable("table")
    for name, render in _RULES.items():
        markdown.add_render_rule(name, render)
    return markdown


def _table(
    renderer: RendererHTML, tokens: Sequence[Token], index: int, options: Any, env: Any
) -> str:
    """Make a wide table scroll within the page, also by keyboard; its heading is its name."""
    if tokens[index].nesting < 0:
        return "</table></div>\n"
    above = [at for at, token in enumerate(tokens[:index]) if token.type == "heading_open"]
    heading = tokens[above[-1] + 1].content.replace("`", "") if above else ""
    number = env[_TABLES] = env.get(_TABLES, 0) + 1
    label = escapeHtml(f"Table {number}: {heading}")
    return f'<div class="table-wrap" tabindex="0" role="region" aria-label="{label}"><table>\n'


def _cell(renderer: RendererHTML, tokens: Sequence[Token], index: int, *rest: Any) -> str:
    """Align numbers with a class: the content security policy forbids inline styles."""
    token = tokens[index]
    if token.type == "th_open":
        token.attrSet("scope", "col")
    if token.attrs.pop("style", "") == "text-align:right":
        token.attrSet("class", "num")
    return renderer.renderToken(tokens, index, *rest)


def _code(renderer: RendererHTML, tokens: Sequence[Token], index: int, *rest: Any) -> str:
    """Show code with colours and a button to copy it; wide code scrolls, also by keyboard."""
    return code_block(tokens[index].content, tokens[index].info.strip())


def _heading(
    renderer: RendererHTML, tokens: Sequence[Token], index: int, options: Any, env: Any
) -> str:
    """Give a heading the anchor that common Markdown viewers generate, numbered if repeated."""
    words = anchor_of(tokens[index + 1].content)
    times = env[words] = env.get(words, -1) + 1
    tokens[index].attrSet("id", f"{words}-{times}" if times else words)
    return renderer.renderToken(tokens, index, options, env)


def _image(renderer: RendererHTML, tokens: Sequence[Token], index: int, *rest: Any) -> str:
    """Link a figure to its file: on a phone its text is too small to read in the page.

    In place of a moving figure, people who want less motion see the still one beside it.
    """
    tokens[index].attrSet("loading", "lazy")
    source = str(tokens[index].attrs["src"])
    still = source.removesuffix(".webp") + "-still.webp"
    shown = renderer.image(tokens, index, *rest)
    if still in attachments():
        less = '<source media="(prefers-reduced-motion: reduce)" srcset="{}">'
        shown = f"<picture>{less.format(escapeHtml(ADDRESS + still))}{shown}</picture>"
    return f'<a href="{escapeHtml(source)}">{shown}</a>'


_TABLES = "number of tables"  # in the environment of a rendering, beside the anchors of headings
_RULES = {
    "heading_open": _heading,
    "image": _image,
    "table_open": _table,
    "table_close": _table,
    "th_open": _cell,
    "td_open": _cell,
    "fence": _code,
}

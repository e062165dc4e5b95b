"""Code in the documentation: highlighted when it is rendered, with a button to copy it."""

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name
from pygments.lexers.special import TextLexer
from pygments.util import ClassNotFound

# Classes only: the content security policy forbids inline styles. The colours are in pages.css.
_FORMATTER = HtmlFormatter(nowrap=True)


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

"""Reading the parameters that a program declares, without running it: a reader per form."""

from collections.abc import Callable, Mapping

from seamark.programs.declarations import comments, fmu, python
from seamark.programs.declarations.declared import Declared
from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import Declarations

_READERS: Mapping[Declarations, Callable[[bytes, str], Declared]] = {
    Declarations.LITERAL: python.read,
    Declarations.COMMENTS: comments.read,
    Declarations.MODEL: fmu.read,
}
# One of these words is in every text that declares something; the form sends no other text to the
# server while its author is writing.
MARKS = (python.NAME, comments.MARK)


def read(language: str, source: bytes, filename: str) -> Declared:
    """Return the parameters of a program, and what is wrong with their declarations.

    Parameters
    ----------
    source
        The main file; of an FMU the whole archive.
    """
    reader = _READERS.get(LANGUAGES[language].declarations)
    return Declared() if reader is None else reader(source, filename)

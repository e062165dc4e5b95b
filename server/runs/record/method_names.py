"""The name of a method: what a published run is called on leaderboards, badges and in citations."""

import re
from collections.abc import Iterable

from seamark.sandbox.printable_text import visible_text
from seamark.server.runs.record.solutions import HasTeam, solution

METHOD_MAX = 60  # [character]
_NAME_MIN = 3  # [character]; a shorter name of a person may well be a word of a method
REQUIRED = (
    "Name the method, such as “Sliding mode with observer”: leaderboards, badges and citations "
    "show it."
)
IS_FILE = "This is the name of the file. Enter the name of your method."


def clean(text: str) -> str:
    """Return a name as it is stored: one line, printable."""
    return " ".join(visible_text(re.sub(r"\s+", " ", text)).split())


def key(name: str) -> str:
    """Return what two names have in common if they are those of one method."""
    return clean(name).casefold()


def suggested(run: HasTeam, *, title: str = "") -> str:
    """Return the name that a run may have without being asked for; empty with a user's program."""
    own = run.program_name or run.parts
    return clean(title)[:METHOD_MAX] or ("" if own else solution(run)[:METHOD_MAX])


def refusal(name: str, *, program_name: str | None, hidden: Iterable[str] = ()) -> str:
    """Return why a method cannot have a cleaned name; empty if it can.

    Parameters
    ----------
    program_name
        Of the uploaded program.
    hidden
        Names of the author, if nobody is to see who that is.
    """
    if not name:
        return REQUIRED
    if len(name) > METHOD_MAX:
        return f"Shorten the name of the method to {METHOD_MAX} characters; it has {len(name)}."
    if program_name and name.casefold() == program_name.casefold():
        return IS_FILE
    for person in hidden:
        if _mentions(name, person):
            return f"The name of the method names you: leave “{person}” out of it."
    return ""


def _mentions(name: str, person: str) -> bool:
    if len(person) < _NAME_MIN:
        return False
    words = rf"(?<!\w){re.escape(person.casefold())}(?!\w)"
    return re.search(words, name.casefold()) is not None

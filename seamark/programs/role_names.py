"""Which of the programs of a run a sentence is about, where several take part.

The sandbox says "The program ...": it has one, and does not know of the others.
"""

import re

_PROGRAM = "The program "
_OF_ROLE = re.compile(r"^The (?:controller|tracker|detector)(: | )")


def with_role(sentence: str, role: str) -> str:
    """Return a sentence of the sandbox that says which program it is about.

    "The program was ended by SIGSEGV." becomes "The tracker was ended by SIGSEGV.", any other one
    "The tracker: ZeroDivisionError: division by zero."
    """
    if sentence.startswith(f"The {role} "):
        return sentence
    if sentence.startswith(_PROGRAM):
        return f"The {role} {sentence.removeprefix(_PROGRAM)}"
    return f"The {role}: {sentence}"


def without_role(sentence: str) -> str:
    """Return what `with_role` was given; any other sentence is unchanged."""
    named = _OF_ROLE.match(sentence)
    if named is None:
        return sentence
    return ("" if named[1] == ": " else _PROGRAM) + sentence[named.end() :]

"""Codes that classes and teams are joined by: whoever knows one may join."""

import secrets

# Digits and capitals that nobody confuses, as in Crockford's base 32: 10 of them are 50 bits. At
# the rate of guesses that the server allows, hitting one of 1000 codes takes millions of years.
_ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
_LENGTH = 10
_MISREAD = str.maketrans("OIL", "011", "- ")


def new() -> str:
    """Return a code that nobody knows yet."""
    return "".join(secrets.choice(_ALPHABET) for _ in range(_LENGTH))


def shown(code: str) -> str:
    """Return a code as people read it out: in two halves."""
    half = _LENGTH // 2
    return f"{code[:half]}-{code[half:]}"


def read(text: str) -> str:
    """Return the code in what somebody typed: as it is shown, misread, or a link that ends so."""
    return text.rpartition("/")[2].upper().translate(_MISREAD)

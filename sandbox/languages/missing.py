"""What this machine lacks for some languages; `./run` installs it.

`python -m seamark.sandbox.languages.missing packages` prints packages of Debian, `sentence` what
programs cannot run without them. Both print nothing if nothing is missing.
"""

import sys
from collections.abc import Iterator, Sequence

from seamark.sandbox.languages import LANGUAGES
from seamark.sandbox.languages.language import Language
from seamark.sandbox.outcome import SandboxBroken


def missing() -> Iterator[Language]:
    """Iterate over the languages whose compiler or interpreter is not installed."""
    for language in LANGUAGES.values():
        try:
            for needed in filter(None, (language.compiler, language.runtime)):
                needed()
        except SandboxBroken:
            yield language


def packages(languages: Sequence[Language]) -> str:
    """Return the packages of these languages, each once."""
    return " ".join(dict.fromkeys(name for one in languages for name in one.debian_packages))


def sentence(languages: Sequence[Language]) -> str:
    """Return what is unavailable, and how to install it."""
    labels = ", ".join(one.short_label for one in languages)
    return f"Unavailable programs: {labels}. Install: apt-get install {packages(languages)}"


if __name__ == "__main__":
    installable = [one for one in missing() if one.debian_packages]
    if installable:
        print({"packages": packages, "sentence": sentence}[sys.argv[1]](installable))

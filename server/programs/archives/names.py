"""Which names a file in an archive may have: those that mean the same everywhere."""

import re
import unicodedata

from seamark.server.programs.archives.reading import shown

LENGTH_MAX, DEPTH_MAX = 180, 10
RESERVED = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)
DRIVE = re.compile(r"[A-Za-z]:")
FORBIDDEN = frozenset('<>:"|?*')  # not allowed on Windows, where a file may be looked at


class NameRefused(Exception):
    """A name that is not allowed. The text is for the archive's owner."""


class Names:
    """The names of one archive so far."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._count = 0
        self._taken: dict[str, str] = {}  # folded -> the name as it was first seen
        self._folders: set[str] = set()  # folded

    def take(self, name: str, *, is_folder: bool) -> str:
        """Return the path of a member that may be there; raises NameRefused."""
        self._count += 1
        if self._count > self._most:
            raise NameRefused(f"The archive has more than {self._most} entries.")
        path = checked(name.rstrip("/") if is_folder else name)
        key = folded(path)
        above = [
            folded("/".join(path.split("/")[:depth])) for depth in range(1, path.count("/") + 1)
        ]
        if not is_folder:
            self._refuse_clash(path, key)
            self._taken[key] = path
        elif key in self._taken:
            raise NameRefused(f"{path} is a file and a folder at once.")
        if clash := next((part for part in above if part in self._taken), None):
            raise NameRefused(f"{self._taken[clash]} is a file and a folder at once.")
        self._folders.update(above, [key] if is_folder else [])
        return path

    def _refuse_clash(self, path: str, key: str) -> None:
        if key in self._folders:
            raise NameRefused(f"{path} is a file and a folder at once.")
        if key not in self._taken:
            return
        other = self._taken[key]
        if other == path:
            raise NameRefused(f"{path} is in the archive twice.")
        raise NameRefused(f"{other} and {path} differ only in upper and lower case.")


def folded(path: str) -> str:
    """Return what two names have in common that some system takes for the same."""
    return unicodedata.normalize("NFC", path.casefold())


def checked(name: str) -> str:
    """Return the name if it is a plain relative path; raises NameRefused."""
    wrong = _wrong(name) or next(filter(None, map(_wrong_part, name.split("/"))), None)
    if wrong:
        raise NameRefused(f'The name "{shown(name)}" {wrong}.')
    return name


def _wrong(name: str) -> str | None:
    """Return what is wrong with a whole name."""
    rules = (
        (not name, "is empty"),
        ("\\" in name, "has a backslash; folders are separated by /"),
        (name.startswith("/") or bool(DRIVE.match(name)), "is absolute; it must be relative"),
        (len(name) > LENGTH_MAX, f"is longer than {LENGTH_MAX} characters"),
        (name.count("/") >= DEPTH_MAX, f"is more than {DEPTH_MAX} folders deep"),
        (any(_hidden(c) for c in name), "has characters that cannot be seen"),
        (unicodedata.normalize("NFKC", name) != unicodedata.normalize("NFC", name), _ALIKE),
    )
    return next((sentence for broken, sentence in rules if broken), None)


_ALIKE = "has characters that look like others; write it with plain letters"


def _hidden(character: str) -> bool:
    """Return whether it is a control, format, surrogate, private or unassigned character."""
    return unicodedata.category(character)[0] == "C"


def _wrong_part(part: str) -> str | None:
    """Return what is wrong with one folder's or file's own name."""
    rules = (
        (part == "..", "leads out of the archive"),
        (part in {"", "."}, "has an empty part"),
        (part[-1:] in {".", " "} or part[:1] == " ", "has a part with a space or dot at its end"),
        (bool(FORBIDDEN & set(part)), 'has one of the characters < > : " | ? *'),
        (bool(RESERVED.fullmatch(part)), "is reserved on Windows"),
    )
    return next((sentence for broken, sentence in rules if broken), None)

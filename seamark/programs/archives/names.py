"""Rules for file names in archives: only names with the same meaning on all systems."""

import re
import unicodedata

from seamark.programs.archives.reading import shown

LENGTH_MAX, DEPTH_MAX = 180, 10
RESERVED = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9]|lpt[0-9])(\..*)?", re.IGNORECASE)
DRIVE = re.compile(r"[A-Za-z]:")
FORBIDDEN = frozenset('<>:"|?*')  # not allowed on Windows


class NameRefused(Exception):
    """A name is not allowed. The text is for the user."""


class Names:
    """The names found so far in one archive."""

    def __init__(self, most: int) -> None:
        self._most = most
        self._count = 0
        self._files: dict[str, str] = {}  # folded path -> path
        self._folders: set[str] = set()  # folded paths

    def add(self, name: str, *, is_folder: bool) -> str:
        """Add a member and return its path; raises NameRefused."""
        self._count += 1
        if self._count > self._most:
            raise NameRefused(f"The archive has more than {self._most} entries.")
        path = checked(name.rstrip("/") if is_folder else name)
        key = folded(path)
        parents = [
            folded("/".join(path.split("/")[:depth])) for depth in range(1, path.count("/") + 1)
        ]
        if not is_folder:
            self._refuse_clash(path, key)
            self._files[key] = path
        elif key in self._files:
            raise NameRefused(f"{path} is both a file and a folder.")
        if clash := next((part for part in parents if part in self._files), None):
            raise NameRefused(f"{self._files[clash]} is both a file and a folder.")
        self._folders.update(parents, [key] if is_folder else [])
        return path

    def _refuse_clash(self, path: str, key: str) -> None:
        if key in self._folders:
            raise NameRefused(f"{path} is both a file and a folder.")
        if key not in self._files:
            return
        other = self._files[key]
        if other == path:
            raise NameRefused(f"{path} is in the archive twice.")
        raise NameRefused(f"{other} and {path} differ only in upper and lower case.")


def folded(path: str) -> str:
    """Return a key that is equal for names that are the same file on some system."""
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
        ("\\" in name, "contains a backslash; use / between folders"),
        (name.startswith("/") or bool(DRIVE.match(name)), "is absolute; it must be relative"),
        (len(name) > LENGTH_MAX, f"is longer than {LENGTH_MAX} characters"),
        (name.count("/") >= DEPTH_MAX, f"is more than {DEPTH_MAX} folders deep"),
        (any(_hidden(c) for c in name), "contains invisible characters"),
        (unicodedata.normalize("NFKC", name) != unicodedata.normalize("NFC", name), _ALIKE),
    )
    return next((sentence for broken, sentence in rules if broken), None)


_ALIKE = "contains characters that look like others; use plain letters"


def _hidden(character: str) -> bool:
    """Return whether it is a control, format, surrogate, private or unassigned character."""
    return unicodedata.category(character)[0] == "C"


def _wrong_part(part: str) -> str | None:
    """Return what is wrong with the name of a single file or folder."""
    rules = (
        (part == "..", "points outside the archive"),
        (part in {"", "."}, "has an empty part"),
        (
            part[-1:] in {".", " "} or part[:1] == " ",
            "has a part with a leading or trailing space or dot",
        ),
        (bool(FORBIDDEN & set(part)), 'contains one of the characters < > : " | ? *'),
        (bool(RESERVED.fullmatch(part)), "is reserved on Windows"),
    )
    return next((sentence for broken, sentence in rules if broken), None)

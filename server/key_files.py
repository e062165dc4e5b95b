"""The keys of a service that are drawn once and kept in its data folder."""

import os
import secrets
from pathlib import Path

KEY_FILES = {"secret_key": "secret", "seed_key": "seed_key"}  # of the settings -> their files
_WITHOUT = {
    "secret": "Delete it, and another one is drawn: everybody has to sign in again",
    "seed_key": "It decides the water of ranked runs: write the key of this service into it, from "
    "a backup or another machine. Delete it only where there have been no ranked runs",
}


class KeyEmpty(Exception):
    """The file of a key is empty: what drew or wrote it has failed. The text says what to do."""


def drawn() -> str:
    """Return a new key."""
    return secrets.token_urlsafe(48)


def kept(path: Path, first: str = "") -> str:
    """Return the key in a file, which gets `first` if it is not there. Race-free."""
    if not path.exists():
        draft = path.with_name(f"{path.name}.{secrets.token_hex(8)}")
        with open(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(first)
            file.flush()
            os.fsync(file.fileno())  # else a power cut could leave an empty file
        try:
            os.link(draft, path)  # fails if another process was faster: then its key counts
        except FileExistsError:
            pass
        finally:
            draft.unlink()
    key = path.read_text(encoding="utf-8").strip()
    if not key:
        raise KeyEmpty(f"{path} is empty. {_WITHOUT[path.name]}")
    return key

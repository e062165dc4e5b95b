"""Whether a program is the starter of its language, as it was given out."""

import hashlib
from functools import lru_cache

from seamark.sandbox.languages import LANGUAGES


def is_untouched(sha256: str | None) -> bool:
    """Return whether a stored program is a starter that nobody has changed."""
    return sha256 in _hashes()


@lru_cache(maxsize=1)
def _hashes() -> frozenset[str]:
    """Return the SHA-256 of all starters; those that an archive carries have that of the archive.

    The editor of the form may have dropped the end of the last line.
    """
    uploads = [starter.upload() for each in LANGUAGES.values() for starter in each.starters]
    texts = {kept for upload in uploads for kept in (upload, upload.rstrip())}
    return frozenset(hashlib.sha256(text).hexdigest() for text in texts)

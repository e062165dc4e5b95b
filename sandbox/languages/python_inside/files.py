"""The files of a program: one text, or an archive that is unpacked in here and nowhere else.

The trusted side has read the archive already and packed it anew (server/archives). The same limits
stand here once more, since this side does not know that.
"""

import io
import linecache
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from zipfile import ZipFile

FOLDER = "/tmp/program"  # noqa: S108  (of the box, gone with it)
MAIN = "main.py"
MAGIC = b"PK\x03\x04"
MOST_FILES = 1000
MOST_BYTES = 64 << 20  # the size of /tmp is the limit; this one is for sizes that lie


class ArchiveUnusable(Exception):
    """The archive cannot be unpacked. The text is for its owner."""


class Files:
    """What was uploaded: `path` and `source` of the file to begin with, and its `name`."""

    def __init__(self, blob: bytes, filename: str) -> None:
        self.name = self.path = filename
        self.source = blob
        self.folder = ""
        if blob.startswith(MAGIC):
            self.folder = FOLDER + "/"
            self.name, self.path = MAIN, self.folder + MAIN
            self.source = unpacked(blob)
            sys.path.insert(0, FOLDER)  # the modules beside main.py
            os.chdir(FOLDER)  # and the data
            return
        lines = blob.decode("utf-8", "replace").splitlines(keepends=True)
        linecache.cache[filename] = (len(blob), None, lines, filename)

    def own(self, filename: str) -> bool:
        """Tell whether a frame of this file is the program's."""
        return filename == self.path or bool(self.folder and filename.startswith(self.folder))

    def shown(self, text: str) -> str:
        """Return text with the files named as they are in the archive."""
        return text.replace(self.folder, "") if self.folder else text


def unpacked(blob: bytes) -> bytes:
    """Unpack the archive into its folder; return main.py."""
    import zipfile  # noqa: PLC0415  (5 ms that a single file need not wait for)

    try:
        with zipfile.ZipFile(io.BytesIO(blob)) as archive:
            return unpack(archive)
    except (zipfile.BadZipFile, OSError, ValueError, EOFError, RuntimeError) as error:
        raise ArchiveUnusable(f"The archive cannot be unpacked: {error}.") from None


def unpack(archive: "ZipFile") -> bytes:
    """Do what `unpacked` does, with the errors of whatever breaks."""
    entries = archive.infolist()
    if len(entries) > MOST_FILES or sum(entry.file_size for entry in entries) > MOST_BYTES:
        raise ArchiveUnusable("The archive has too many files or too much in them.")
    for entry in entries:
        write(entry.filename, archive.read(entry))
    if MAIN not in archive.namelist():
        raise ArchiveUnusable(f"The archive has no {MAIN} at its top.")
    return archive.read(MAIN)


def write(name: str, content: bytes) -> None:
    """Write one file below the folder."""
    parts = name.split("/")
    if not parts[0] or ".." in parts or "\0" in name:
        raise ArchiveUnusable(f"The archive has a file of the name {name!r}.")
    path = os.path.join(FOLDER, *parts)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "xb") as file:
        file.write(content)

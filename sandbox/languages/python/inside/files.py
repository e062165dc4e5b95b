"""The files of a program: one text, or an archive, which is unpacked here and nowhere else.

The server has checked the archive and packed it again (seamark/programs/archives). Its limits are
repeated here, since this end cannot rely on that.
"""

import io
import linecache
import os
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from zipfile import ZipFile

FOLDER = "/tmp/program"  # noqa: S108  (inside the box)
# The first that is there is the program.
MAINS = ("main.py", "controller.py", "tracker.py", "detector.py")
MAGIC = b"PK\x03\x04"
MAX_FILES = 1000
MAX_BYTES = 64 << 20  # the real limit is the size of /tmp; declared sizes may be wrong


class ArchiveUnusable(Exception):
    """The archive cannot be unpacked. The text is for its owner."""


class Files:
    """The upload: `name`, `path` and `source` of its main file."""

    def __init__(self, blob: bytes, filename: str) -> None:
        self.name = self.path = filename
        self.source = blob
        self.folder = ""
        if blob.startswith(MAGIC):
            self.folder = FOLDER + "/"
            self.name, self.source = unpacked(blob)
            self.path = self.folder + self.name
            sys.path.insert(0, FOLDER)  # the modules beside the main file
            os.chdir(FOLDER)  # and the data
            return
        lines = blob.decode("utf-8", "replace").splitlines(keepends=True)
        linecache.cache[filename] = (len(blob), None, lines, filename)

    def contains(self, filename: str) -> bool:
        """Return whether a file of a traceback belongs to the program."""
        return filename == self.path or bool(self.folder and filename.startswith(self.folder))

    def with_own_names(self, text: str) -> str:
        """Return text with the file names as they are in the archive."""
        return text.replace(self.folder, "") if self.folder else text


def unpacked(blob: bytes) -> tuple[str, bytes]:
    """Unpack the archive into its folder; return name and content of its main file."""
    import zipfile  # noqa: PLC0415  (5 ms that a single file does not need)
    import zlib  # noqa: PLC0415

    try:
        with zipfile.ZipFile(io.BytesIO(blob)) as archive:
            return unpack(archive)
    except (zipfile.BadZipFile, zlib.error, OSError, ValueError, EOFError, RuntimeError) as error:
        raise ArchiveUnusable(f"The archive cannot be unpacked: {error}.") from None


def unpack(archive: "ZipFile") -> tuple[str, bytes]:
    """Write all files below the folder; return name and content of the main file."""
    entries = archive.infolist()
    if len(entries) > MAX_FILES or sum(entry.file_size for entry in entries) > MAX_BYTES:
        raise ArchiveUnusable("The archive has too many files or too much in them.")
    for entry in entries:
        write(entry.filename, archive.read(entry))
    names = set(archive.namelist())
    for main in MAINS:
        if main in names:
            return main, archive.read(main)
    raise ArchiveUnusable(f"The archive has none of {', '.join(MAINS)} at its top.")


def write(name: str, content: bytes) -> None:
    """Write one file below the folder."""
    parts = name.split("/")
    if not parts[0] or ".." in parts or "\0" in name:
        raise ArchiveUnusable(f"The archive has a file of the name {name!r}.")
    path = os.path.join(FOLDER, *parts)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "xb") as file:
        file.write(content)

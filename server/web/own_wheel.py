"""The wheel of the running version, made of its own files.

A checkout and an installed package have the same files below `seamark`, so this needs neither a
build tool nor the sources. The same files always give the same bytes.
"""

import base64
import csv
import hashlib
import importlib.metadata
import io
import threading
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from seamark import server

PACKAGE = Path(server.__file__).parents[
    1
]  # the folder `seamark`: links to the others in a checkout
# As in pyproject.toml: made on this machine, or large and read by nothing.
LEFT_OUT = ("__pycache__", "screenshots")
MADE_HERE = "visp-bridge-"
_MADE_AT = (1980, 1, 1, 0, 0, 0)  # the first that a zip archive knows
_METADATA = ("METADATA", "WHEEL", "entry_points.txt", "licenses/LICENSE")


@dataclass(frozen=True, slots=True)
class Wheel:
    """A wheel in memory."""

    name: str
    content: bytes
    sha256: str


class OwnWheel:
    """The wheel of this version; the first use makes it, which takes about a second."""

    def __init__(self) -> None:
        self._lock = threading.Lock()  # many first requests at once make one wheel
        self._wheel: Wheel | None = None

    def get(self) -> Wheel:
        """Return the wheel."""
        with self._lock:
            if self._wheel is None:
                content = _content()
                self._wheel = Wheel(name(), content, hashlib.sha256(content).hexdigest())
            return self._wheel


def name() -> str:
    """Return the file name that installers expect of the wheel."""
    return f"{_stem()}-py3-none-any.whl"


def _stem() -> str:
    return f"seamark-{importlib.metadata.version('seamark')}"


def _content() -> bytes:
    record = io.StringIO()
    rows = csv.writer(record, lineterminator="\n")
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in _files():
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            rows.writerow((path, f"sha256={digest}", len(data)))
            _write(archive, path, data)
        own = f"{_stem()}.dist-info/RECORD"
        rows.writerow((own, "", ""))
        _write(archive, own, record.getvalue().encode())
    return target.getvalue()


def _write(archive: zipfile.ZipFile, path: str, data: bytes) -> None:
    entry = zipfile.ZipInfo(path, _MADE_AT)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data)


def _files() -> Iterator[tuple[str, bytes]]:
    """Yield path and content of all files: those of the package, then its metadata."""
    for top in sorted(PACKAGE.iterdir()):
        for path in [top] if top.is_file() else sorted(top.rglob("*")):
            inside = path.relative_to(PACKAGE)
            if path.is_file() and _belongs(inside):
                yield f"seamark/{inside.as_posix()}", path.read_bytes()
    installed = importlib.metadata.distribution("seamark")
    for each in _METADATA:
        text = installed.read_text(each)
        if text is None:
            raise FileNotFoundError(f"the installed seamark lacks {each}")
        yield f"{_stem()}.dist-info/{each}", text.encode()


def _belongs(inside: Path) -> bool:
    hidden = any(part.startswith(".") for part in inside.parts)
    return not (hidden or set(LEFT_OUT) & set(inside.parts) or inside.name.startswith(MADE_HERE))

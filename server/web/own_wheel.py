"""The wheels of the running version, made of its own files: the simulator and the client alone.

A checkout and an installed package have the same files below `seamark`, so this needs neither a
build tool nor the sources. The same files always give the same bytes. No file is in both wheels,
because installers would then remove files of the one with the other; that of the simulator depends
on that of the client instead, at the address of the same service.
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
# As in pyproject.toml: made on this machine.
LEFT_OUT = ("__pycache__",)
MADE_HERE = "visp-bridge-"
# As in deploy/client/pyproject.toml: files and folders of the client, the others are the simulator.
CLIENT = (
    "__init__.py",
    "cli",
    "client",
    "drafts.py",
    "failures.py",
    "formats/__init__.py",
    "formats/registry.py",
    "progress.py",
    "programs/__init__.py",
    "programs/licences.py",
    "py.typed",
    "sandbox/__init__.py",
    "sandbox/printable_text.py",
)
TAGS = {"seamark": "py3-none-manylinux_2_28_x86_64", "seamark-client": "py3-none-any"}
_MADE_AT = (1980, 1, 1, 0, 0, 0)  # the first that a zip archive knows


@dataclass(frozen=True, slots=True)
class Wheel:
    """A wheel in memory."""

    name: str
    content: bytes
    sha256: str


class OwnWheel:
    """A wheel of this version; the first use compresses its files, which takes about a second.

    Parameters
    ----------
    distribution
        `seamark` or `seamark-client`.
    """

    def __init__(self, distribution: str) -> None:
        self._distribution = distribution
        self.name = file_name(distribution)
        self._lock = threading.Lock()  # many first requests at once compress the files once
        self._files: tuple[bytes, str] | None = None  # as a zip archive, and their rows of RECORD

    def get(self, host: str) -> Wheel:
        """Return the wheel that a service at the address `host` offers."""
        with self._lock:
            if self._files is None:
                self._files = _zipped(_files(self._distribution))
        archive, rows = self._files
        target = io.BytesIO()
        target.write(archive)
        stem = f"{_stem(self._distribution)}.dist-info"
        last = {f"{stem}/METADATA": _metadata(self._distribution, host).encode()}
        own = f"{stem}/RECORD"
        last[own] = f"{rows}{_record(last)}{own},,\n".encode()
        with zipfile.ZipFile(target, "a") as wheel:
            for path, data in last.items():
                _add(wheel, path, data)
        content = target.getvalue()
        return Wheel(self.name, content, hashlib.sha256(content).hexdigest())


def file_name(distribution: str) -> str:
    """Return the file name that installers expect of a wheel."""
    return f"{_stem(distribution)}-{TAGS[distribution]}.whl"


def _stem(distribution: str) -> str:
    return f"{distribution.replace('-', '_')}-{importlib.metadata.version('seamark')}"  # of both


def _zipped(files: Iterator[tuple[str, bytes]]) -> tuple[bytes, str]:
    target, rows = io.BytesIO(), []
    with zipfile.ZipFile(target, "w") as archive:
        for path, data in files:
            _add(archive, path, data)
            rows.append(_record({path: data}))
    return target.getvalue(), "".join(rows)


def _record(files: dict[str, bytes]) -> str:
    """Return the lines of RECORD for some files."""
    lines = io.StringIO()
    rows = csv.writer(lines, lineterminator="\n")
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        rows.writerow((path, f"sha256={digest}", len(data)))
    return lines.getvalue()


def _add(archive: zipfile.ZipFile, path: str, data: bytes) -> None:
    entry = zipfile.ZipInfo(path, _MADE_AT)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    archive.writestr(entry, data)


def _files(distribution: str) -> Iterator[tuple[str, bytes]]:
    """Yield path and content of all files that no address changes."""
    for top in sorted(PACKAGE.iterdir()):
        for path in [top] if top.is_file() else sorted(top.rglob("*")):
            inside = path.relative_to(PACKAGE)
            if path.is_file() and _belongs(inside) and distribution_of(inside) == distribution:
                yield f"seamark/{inside.as_posix()}", path.read_bytes()
    stem = f"{_stem(distribution)}.dist-info"
    tags = f"Root-Is-Purelib: true\nTag: {TAGS[distribution]}\n"
    yield f"{stem}/WHEEL", f"Wheel-Version: 1.0\nGenerator: seamark\n{tags}".encode()
    if distribution == "seamark-client":
        yield f"{stem}/entry_points.txt", _installed(distribution, "entry_points.txt").encode()
    yield f"{stem}/licenses/LICENSE", _installed(distribution, "licenses/LICENSE").encode()


def distribution_of(inside: Path) -> str:
    """Return the distribution of a file, given its path below the folder `seamark`."""
    client = any(inside.is_relative_to(part) for part in CLIENT)
    return "seamark-client" if client else "seamark"


def _metadata(distribution: str, host: str) -> str:
    """Return METADATA in which the simulator takes the client from the same service."""
    text = _installed(distribution, "METADATA")
    client = f"seamark-client=={importlib.metadata.version('seamark')}"
    address = f"seamark-client @ {host}/download/{file_name('seamark-client')}"
    return text.replace(f"Requires-Dist: {client}\n", f"Requires-Dist: {address}\n")


def _installed(distribution: str, name: str) -> str:
    text = importlib.metadata.distribution(distribution).read_text(name)
    if text is None:
        raise FileNotFoundError(f"the installed {distribution} lacks {name}")
    return text


def _belongs(inside: Path) -> bool:
    hidden = any(part.startswith(".") for part in inside.parts)
    return not (hidden or set(LEFT_OUT) & set(inside.parts) or inside.name.startswith(MADE_HERE))

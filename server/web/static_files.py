"""Scripts, styles and pictures of the pages, at addresses that change with what is in them.

A browser that has a file asks for it no more; before, the page of a run asked 56 times whether
something had changed. The version is a folder in the address, so that modules still import each
other by relative paths.
"""

import hashlib
import re
from functools import cache
from pathlib import Path
from typing import Any

from flask import Flask, Response, send_from_directory

from seamark.server.web.security_headers import ONE_YEAR_S

_VERSION = re.compile(r"[0-9a-f]{16}")


def register(app: Flask, folder: Path) -> None:
    """Serve the files of a folder, and let `url_for` name them with their version.

    Under another version, as on a page from before an upgrade, and without one a file is what it
    is now, and a browser asks again each time.
    """
    version = _version_of(folder)

    @app.endpoint("static")
    def send(filename: str) -> Response:
        first, _, rest = filename.partition("/")
        response = send_from_directory(folder, rest if _VERSION.fullmatch(first) else filename)
        if first == version:
            response.cache_control.no_cache = None
            response.cache_control.public = True
            response.cache_control.max_age = ONE_YEAR_S
            response.cache_control.immutable = True
        return response

    app.add_url_rule("/static/<path:filename>", "static")

    @app.url_defaults
    def add_version(endpoint: str, values: dict[str, Any]) -> None:
        if endpoint == "static":
            values["filename"] = f"{version}/{values['filename']}"


@cache
def _version_of(folder: Path) -> str:
    """Return what stands for the content of all files together: some refer to others."""
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        content = hashlib.sha256(path.read_bytes()).hexdigest()
        digest.update(f"{path.relative_to(folder)}\0{content}\0".encode())
    return digest.hexdigest()[:16]

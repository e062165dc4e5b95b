"""Where a browser is sent: within this site, unless a route says otherwise."""

from urllib.parse import urlsplit

from flask import g, redirect, url_for
from werkzeug.wrappers import Response


def own_path(wanted: str) -> str:
    """Return `wanted` if it is an address on this site, else that of the home page."""
    target = wanted.replace("\\", "/")
    parts = urlsplit(target)
    is_path = target.startswith("/") and not target.startswith("//")
    return target if is_path and not parts.netloc and target.isprintable() else url_for("home.show")


def leave_for(address: str) -> Response:
    """Redirect to another site, which the operator has named."""
    g.leaves_for = address
    return redirect(address)


def leaves() -> bool:
    """Return whether `leave_for` has made the answer to this request."""
    return "leaves_for" in g

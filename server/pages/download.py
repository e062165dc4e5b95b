"""The command line of this version, as a wheel that pip, pipx and uv install."""

from flask import Blueprint, Response, abort, request
from flask.typing import ResponseReturnValue

from seamark.server.web import own_wheel
from seamark.server.web.own_wheel import OwnWheel

page = Blueprint("download", __name__, url_prefix="/download")
_wheel = OwnWheel()


@page.get("/<name>")
def wheel(name: str) -> ResponseReturnValue:
    """Send the wheel; its name holds the version."""
    if name != own_wheel.name():
        abort(404)
    found = _wheel.get()
    answer = Response(found.content, mimetype="application/zip")
    answer.headers["Content-Disposition"] = f'attachment; filename="{found.name}"'
    answer.set_etag(found.sha256)
    answer.cache_control.no_cache = True  # the same version may change while it is developed
    answer.cache_control.public = True
    return answer.make_conditional(request, accept_ranges=True, complete_length=len(found.content))

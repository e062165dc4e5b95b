"""The simulator and the client of this version, as wheels that pip, pipx and uv install."""

from flask import Blueprint, Response, abort, request
from flask.typing import ResponseReturnValue

from seamark.server.web.own_wheel import TAGS, OwnWheel
from seamark.server.web.site_address import site_address

page = Blueprint("download", __name__, url_prefix="/download")
_WHEELS = {wheel.name: wheel for wheel in map(OwnWheel, TAGS)}


@page.get("/<name>")
def wheel(name: str) -> ResponseReturnValue:
    """Send a wheel; its name holds the version."""
    if name not in _WHEELS:
        abort(404)
    wheel_file = _WHEELS[name].get(site_address())
    answer = Response(wheel_file.content, mimetype="application/zip")
    answer.headers["Content-Disposition"] = f'attachment; filename="{wheel_file.name}"'
    answer.set_etag(wheel_file.sha256)
    answer.cache_control.no_cache = True  # the same version may change while it is developed
    return answer.make_conditional(
        request, accept_ranges=True, complete_length=len(wheel_file.content)
    )

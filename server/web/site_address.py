"""The address of this service, for texts that people copy and for what they download."""

from flask import request

from seamark.server.web.services import services


def site_address() -> str:
    """Return scheme, host and port: of the settings, else of the request, as its client sent it.

    So it must not be in what one person's request leaves for another person to read.
    """
    return services().settings.url or request.host_url.rstrip("/")

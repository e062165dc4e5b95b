"""HTTP caching of API responses."""

from flask import Response, request


def conditional(response: Response) -> Response:
    """Answer 304 without a body if the client already has this representation."""
    response.headers["Vary"] = "Authorization, Cookie"
    response.make_conditional(request)
    return response

"""Files in the OpenAPI document."""

from typing import Any


def answers_with(media_type: str, kind: str = "string") -> Any:
    """Return the description of an answer that is a file.

    Parameters
    ----------
    kind
        What clients make of it: "string", or "object" for JSON and YAML.
    """
    return {200: {"content": {media_type: {"schema": {"type": kind}}}}}

"""The names of the operations in the OpenAPI document, of which generators make function names."""

from __future__ import annotations


def operation_id(*, bp_name: str, name: str, path: str, method: str) -> str:
    """Return the name of an operation, such as `runs_show`; paths and methods may change."""
    return f"{bp_name.removeprefix('api_')}_{name}"

"""Seamark: simulator, command line and Python client (`from seamark import Client`)."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seamark.client import AsyncClient, Client

__all__ = ["AsyncClient", "Client"]


def __getattr__(name: str) -> Any:
    """Import the client when it is used: `import seamark` itself loads nothing."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module("seamark.client"), name)

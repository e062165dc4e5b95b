"""The uploads go through the real route: the application of the interface's own tests."""

from tests.server.api.conftest import Site, site

__all__ = ["Site", "site"]

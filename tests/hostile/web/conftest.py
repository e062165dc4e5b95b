"""The attacks use the browsers of the cast, as the tests of the pages do."""

from tests.server.pages.conftest import site

__all__ = ["site"]

"""Hostile uploads go through the route itself: they need the application of the API's tests."""

from tests.server.api.conftest import site

__all__ = ["site"]

"""The worker as a service: claims runs, drives them, stores results."""

import seamark.server.monitoring  # noqa: F401 - has structlog loaded before a module here does

"""Logging: one line per event with its ids, on standard error, for all processes of the service."""

import logging
import sys
from contextlib import suppress

import structlog


class _LastingLogger(structlog.PrintLogger):
    """A full disk costs lines of the log; it does not stop the thread that logs."""

    def msg(self, message: str) -> None:
        with suppress(OSError):
            super().msg(message)

    log = debug = info = warn = warning = msg
    fatal = failure = err = error = critical = exception = msg


def configure(*, debug: bool = False) -> None:
    """Set up structlog; every process of the service calls it once at its start."""
    level = logging.DEBUG if debug else logging.INFO
    stream = sys.stderr
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            structlog.processors.format_exc_info,
            structlog.processors.LogfmtRenderer(key_order=["timestamp", "level", "event"]),
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=lambda *_: _LastingLogger(stream),
        cache_logger_on_first_use=True,
    )

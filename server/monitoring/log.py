"""Logging: one line per event with its ids, on standard error, for all processes of the service.

What users send may stand in any value: JSON escapes all that is not ASCII, and the text for
terminals every character that is not printable, so that no value makes a line of its own or acts
on a terminal.
"""

import logging
import sys
from collections.abc import MutableMapping, Sequence
from contextlib import suppress
from textwrap import indent
from typing import Any, Literal, TextIO

import structlog
from structlog.typing import Processor

from seamark.sandbox.printable_text import printable_text

Level = Literal["debug", "info", "warning", "error"]
Format = Literal["auto", "json", "text"]
REQUEST = "request"  # key of the request's id
VALUE_MAX = 8000  # [character] of a value
_Event = MutableMapping[str, Any]


class _LastingLogger(structlog.PrintLogger):
    """A full disk costs lines of the log; it does not stop the thread that logs."""

    def msg(self, message: str) -> None:
        with suppress(OSError):
            super().msg(message)

    log = debug = info = warn = warning = msg
    fatal = failure = err = error = critical = exception = msg


class _LastingHandler(logging.StreamHandler[TextIO]):
    """Writes the lines of libraries, as `_LastingLogger` does ours."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - of the library
        """Lose the line."""


def configure(level: Level, style: Format = "auto") -> None:
    """Set up the log of this process; every process of the service calls it once at its start.

    Parameters
    ----------
    style
        JSON or text for people; "auto": text on a terminal.
    """
    number, stream = getattr(logging, level.upper()), sys.stderr
    text = style == "text" or (style == "auto" and stream.isatty())
    first: Sequence[Processor] = [
        structlog.contextvars.merge_contextvars,
        structlog.processors.add_log_level,
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        structlog.processors.format_exc_info,
        _shortened,
    ]
    last = _for_people(colours=stream.isatty()) if text else [structlog.processors.JSONRenderer()]
    structlog.configure(
        processors=[*first, *last],
        wrapper_class=structlog.make_filtering_bound_logger(number),
        logger_factory=lambda *_: _LastingLogger(stream),
        cache_logger_on_first_use=True,
    )
    _take_over_libraries(stream, number, [*first, *last])


def request_id() -> str | None:
    """Return the id of the request that this thread answers; None outside of requests."""
    identifier: str | None = structlog.contextvars.get_contextvars().get(REQUEST)
    return identifier


def _take_over_libraries(stream: TextIO, level: int, processors: Sequence[Processor]) -> None:
    """Write warnings of libraries as events, too."""
    handler = _LastingHandler(stream)
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=[structlog.stdlib.add_logger_name],
            processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, *processors],
        )
    )
    logging.basicConfig(handlers=[handler], level=max(level, logging.WARNING), force=True)
    logging.captureWarnings(capture=True)


def _shortened(_logger: object, _name: str, event: _Event) -> _Event:
    for key, value in event.items():
        if isinstance(value, str) and len(value) > VALUE_MAX:
            event[key] = value[: VALUE_MAX // 2] + " [...] " + value[-VALUE_MAX // 2 :]
    return event


def _for_people(*, colours: bool) -> list[Processor]:
    plain = structlog.dev.plain_traceback
    return [_printable, structlog.dev.ConsoleRenderer(colors=colours, exception_formatter=plain)]


def _printable(_logger: object, _name: str, event: _Event) -> _Event:
    for key, value in event.items():
        if isinstance(value, str):
            text = printable_text(value)
            # A traceback has several lines, none of which looks like an event.
            event[key] = indent(text, "    ") if key == "exception" else text.replace("\n", "\\n")
    return event

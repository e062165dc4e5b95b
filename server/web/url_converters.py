"""Row ids in URLs: ids that no database row can have give 404 instead of a database error."""

from flask import Flask
from werkzeug.routing import IntegerConverter, Map

ROW_ID_MAX = 2**53 - 1  # the largest integer that every JSON parser represents exactly


def register(app: Flask) -> None:
    """Add the converter `<row:name>`, which does not match other numbers."""
    app.url_map.converters["row"] = _RowId


def row_id(text: str) -> int:
    """Return the id in a query string; ValueError if no row can have it."""
    number = int(text)
    if not 0 <= number <= ROW_ID_MAX:
        raise ValueError("no row can have this id")
    return number


class _RowId(IntegerConverter):
    def __init__(self, map: Map) -> None:
        super().__init__(map, max=ROW_ID_MAX)

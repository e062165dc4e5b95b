"""Numbers of rows in addresses: what no database could hold is nothing, not our mistake."""

from flask import Flask
from werkzeug.routing import IntegerConverter, Map

ROW_MAX = 2**53 - 1  # as the HTTP interface has it: every reader of JSON keeps it exactly


def register(app: Flask) -> None:
    """Let routes say `<row:name>`; without a row of that number they do not match at all."""
    app.url_map.converters["row"] = _Row


def row_number(text: str) -> int:
    """Return the number in a query string; ValueError if it cannot be that of a row."""
    number = int(text)
    if not 0 <= number <= ROW_MAX:
        raise ValueError("no row has this number")
    return number


class _Row(IntegerConverter):
    """Digits up to the largest number of a row."""

    def __init__(self, map: Map) -> None:
        super().__init__(map, max=ROW_MAX)

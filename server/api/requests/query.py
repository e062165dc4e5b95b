"""The base of what an operation reads from the query or the headers of a request."""

from functools import cache
from typing import Any

from pydantic import BaseModel


class Query(BaseModel):
    """Values of a query, or headers.

    The framework asks for the schema at each request, which takes longer than most answers.
    """

    @classmethod
    def model_json_schema(cls, *args: Any, **options: Any) -> dict[str, Any]:
        """Return the schema; with other options than the defaults it is made anew."""
        if args or options:
            return super().model_json_schema(*args, **options)
        return _schema(cls)


@cache  # as many as there are classes
def _schema(query: type[Query]) -> dict[str, Any]:
    return super(Query, query).model_json_schema()

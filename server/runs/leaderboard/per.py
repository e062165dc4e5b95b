"""What has one row on a leaderboard: a person, or each named method of a person."""

from enum import StrEnum

from sqlalchemy import ColumnElement

from seamark.server.database.tables import Best, BestMethod, BoardRow


class Per(StrEnum):
    """Whose best published ranked run is a row."""

    PERSON = "person"
    METHOD = "method"

    @property
    def table(self) -> type[BoardRow]:
        """The table with these rows."""
        return Best if self is Per.PERSON else BestMethod

    def of_user(self, benchmark: str, user_id: int) -> tuple[ColumnElement[bool], ...]:
        """Return the condition on the rows of one user."""
        return self.table.benchmark == benchmark, self.table.user_id == user_id

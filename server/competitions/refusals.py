"""Why something about a competition is refused."""


class CompetitionRefused(Exception):
    """A rule of competitions is broken. The text is for the user; `field` is at fault."""

    def __init__(self, sentence: str, *, field: str = "") -> None:
        super().__init__(sentence)
        self.field = field

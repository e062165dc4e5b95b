"""Why something about classes is refused."""


class ClassRefused(Exception):
    """A rule of classes or assignments is broken. The text is for the user; `field` is at fault."""

    def __init__(self, sentence: str, *, field: str = "") -> None:
        super().__init__(sentence)
        self.field = field

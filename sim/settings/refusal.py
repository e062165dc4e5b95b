"""What a configuration is refused with. Importing this module does not load pydantic."""

from collections.abc import Mapping


class ConfigurationInvalid(Exception):
    """Values that break the rules of a benchmark. The messages are written for the user.

    Attributes
    ----------
    errors : dict of setting -> message
    """

    def __init__(self, errors: Mapping[str, str]) -> None:
        super().__init__(" ".join(errors.values()))
        self.errors = dict(errors)

    def __reduce__(self) -> tuple[type["ConfigurationInvalid"], tuple[dict[str, str]]]:
        """Return how another process gets it: by its errors, not by its text."""
        return type(self), (self.errors,)

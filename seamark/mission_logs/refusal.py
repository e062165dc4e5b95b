"""Why a log cannot be measured."""


class LogRefused(Exception):
    """The log or its mapping breaks a rule. The text is for the user."""

"""Where the languages are."""

from seamark.sandbox.languages.language import Language


def folder_of(language: Language) -> str:
    """Return the name of a language's folder in sandbox/languages, by its starter."""
    parts = next(iter(language.starters[0].files.values())).parts
    return parts[len(parts) - 1 - parts[::-1].index("languages") + 1]

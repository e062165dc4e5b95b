"""What an owner writes about a run: title and notes. They change at any time, unlike the rest."""

from collections.abc import Mapping

from sqlalchemy import update
from sqlalchemy.orm import Session

from seamark.sandbox.printable_text import visible_text
from seamark.server.database.tables import Run

TITLE_MAX, NOTES_MAX = 120, 4000  # [character]


def clean_title(text: str) -> str:
    """Return a title as it is stored: one line, printable."""
    return visible_text(text).strip()[:TITLE_MAX]


def clean_notes(text: str) -> str:
    """Return notes as they are stored: plain text with line breaks."""
    lines = text.replace("\r\n", "\n")
    return visible_text(lines, keep="\n\t").strip()[:NOTES_MAX]


def annotate(
    session: Session, run_id: int, *, title: str | None = None, notes: str | None = None
) -> None:
    """Change the title, the notes or both; None leaves one as it is."""
    values: Mapping[str, str | None] = {
        "title": None if title is None else clean_title(title),
        "notes": None if notes is None else clean_notes(notes),
    }
    given = {name: value for name, value in values.items() if value is not None}
    if given:
        session.execute(update(Run).where(Run.id == run_id).values(**given))

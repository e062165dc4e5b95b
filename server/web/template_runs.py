"""Practice runs whose settings somebody takes for what others do: an assignment, a competition."""

from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing import run_lists, views
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access
from seamark.server.web.services import services
from seamark.server.web.url_converters import row_id

CHOICES_MAX = 100  # runs that a form offers


class NoTemplate(Exception):
    """A run cannot be taken. The text is for the user."""


def chosen(text: str) -> RunView:
    """Return the practice run with this number if the viewer may see it; raises NoTemplate."""
    try:
        with services().database.reading() as session:
            run = views.show(session, row_id(text))
    except ValueError:
        run = None
    if run is None or not can(access.viewer(), Action.VIEW, run):
        raise NoTemplate("Choose one of your runs.")
    if run.kind is not RunKind.PRACTICE:
        raise NoTemplate("Choose a practice run: others have the benchmark's own scenario.")
    return run


def to_choose(named: str) -> list[RunView]:
    """Return the newest practice runs of the viewer, after the one that an address names."""
    wanted = run_lists.RunFilter(kind=RunKind.PRACTICE)
    with services().database.reading() as session:
        own = run_lists.page(session, access.viewer(), wanted, limit=CHOICES_MAX).runs
    try:
        first = chosen(named)
    except NoTemplate:
        return list(own)
    return [first, *(run for run in own if run.id != first.id)]

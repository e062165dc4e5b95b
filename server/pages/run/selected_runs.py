"""What is done to the runs selected in a list: each as on its own page, where that is allowed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from flask import flash, g
from sqlalchemy.orm import Session

from seamark.server.accounts.permissions import Action, can
from seamark.server.runs.ending import cancellation, deletion
from seamark.server.runs.publication.publications import PublicationRefused, Terms
from seamark.server.runs.showing import views
from seamark.server.web import publication
from seamark.server.web.services import Services, services


@dataclass(frozen=True, slots=True)
class Change:
    """A change of several runs."""

    action: Action
    done: str  # "3 runs were ..."
    why_not: str
    apply: Callable[[Services, Sequence[int]], int]  # returns how many it has changed


def change(name: str, run_ids: Sequence[int]) -> None:
    """Change those of the runs for which it is possible; the next page says how many."""
    wanted = CHANGES.get(name)
    if wanted is None or not run_ids:
        flash("Select runs first, then choose an action.", "warn")
        return
    current = services()
    with current.database.reading() as session:
        shown = [views.show(session, run_id) for run_id in run_ids]
    allowed = [run.id for run in shown if run and can(g.viewer, wanted.action, run)]
    changed = wanted.apply(current, allowed)
    left = len(run_ids) - changed
    if changed:
        flash(f"{_runs(changed)} {wanted.done}.", "good")
    if left:
        flash(
            f"{_runs(left)} left as {'it is' if left == 1 else 'they are'}. {wanted.why_not}",
            "warn",
        )


def _runs(count: int) -> str:
    return "1 run was" if count == 1 else f"{count} runs were"


def _cancel(current: Services, run_ids: Sequence[int]) -> int:
    return sum(cancellation.cancel(current.database, current.redis, run_id) for run_id in run_ids)


def _delete(current: Services, run_ids: Sequence[int]) -> int:
    return len(deletion.delete(current.database, current.settings, run_ids))


def _publish(current: Services, run_ids: Sequence[int]) -> int:
    with current.database.writing() as session:
        return sum(_publish_one(session, run_id) for run_id in run_ids)


def _publish_one(session: Session, run_id: int) -> bool:
    run = views.show(session, run_id)
    method = "" if run is None else run.method
    try:
        return publication.publish(session, run_id, Terms(method=method))
    except PublicationRefused:  # before it has changed anything
        return False


def _withdraw(current: Services, run_ids: Sequence[int]) -> int:
    with current.database.writing() as session:
        return sum(publication.withdraw(session, run_id) for run_id in run_ids)


CHANGES: Mapping[str, Change] = {
    "cancel": Change(
        Action.CANCEL, "cancelled", "Only queued and running runs can be cancelled.", _cancel
    ),
    "delete": Change(Action.DELETE, "deleted", deletion.WHY_NOT, _delete),
    "publish": Change(
        Action.PUBLISH,
        "published",
        "Only an account can publish, and only private runs that have ended and have their data. "
        "Publish a run of your own program on its page, where you name the method.",
        _publish,
    ),
    "withdraw": Change(
        Action.WITHDRAW, "made private", "Only public runs can be made private.", _withdraw
    ),
}

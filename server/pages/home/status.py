"""The state of the service: workers, what their hosts can enforce, the queue."""

from flask import Blueprint, render_template
from flask.typing import ResponseReturnValue

from seamark.sandbox.languages import DEFAULT_LANGUAGE, LANGUAGES
from seamark.server.messaging import workers
from seamark.server.runs.leaderboard import reference_entries
from seamark.server.runs.record import totals
from seamark.server.storage import storage
from seamark.server.web.services import services

page = Blueprint("status", __name__)


@page.get("/status")
def show() -> ResponseReturnValue:
    """Show the workers, the queue and whether uploads are accepted."""
    app_services = services()
    with app_services.database.reading() as session:
        listed = workers.listed(session)
        counts, oldest = totals.counts(session), totals.oldest_queued_at(session)
        deviations = list(reference_entries.deviations(session))
        preparation = workers.preparation(session)
        refusal = workers.upload_refusal(session, DEFAULT_LANGUAGE, app_services.settings)
    return render_template(
        "status/show.html",
        workers=listed,
        labels={name: language.label for name, language in LANGUAGES.items()},
        deviations=deviations,
        preparation=preparation,
        counts={state.value: number for state, number in counts.items()},
        oldest=oldest,
        refusal=storage.refusal(app_services.settings) or refusal,
        needed=app_services.settings.sandbox_min_level,
        streams=app_services.streams.open_streams,
        streams_max=app_services.settings.streams_max,
    )

"""Publications: terms, permanent address and verifications."""

from __future__ import annotations

from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.operation_ids import operation_id
from seamark.server.api.publication_schemas import PublicationResponse
from seamark.server.api.schemas import RunPath
from seamark.server.runs import publications, verifications
from seamark.server.runs.views import RunView
from seamark.server.web import access
from seamark.server.web.problems import Problem
from seamark.server.web.publication import address_of
from seamark.server.web.services import services

api = APIBlueprint(
    "api_publications",
    __name__,
    url_prefix="/api/v1",
    operation_id_callback=operation_id,
    abp_tags=[Tag(name="Publications", description="Published runs: terms, citations, marks.")],
)


@api.get("/runs/<int:run_id>/publication", responses={200: PublicationResponse})
def show(path: RunPath) -> dict[str, Any]:
    """Return the terms of a publication and its verifications; 410 if it has been withdrawn."""
    run = published(path.run_id)
    with services().database.reading() as session:
        first = publications.history(session, run.id)
        pending = verifications.is_pending(session, run.id)
        found = verifications.of_run(session, run.id)
    return {
        "run": run.id,
        "address": address_of(run.id),
        "author": run.user,
        "anonymous": run.anonymous,
        "program_public": run.program_public,
        "licence": run.licence,
        "published_at": run.published_at,
        "first_published_at": first.first_at if first else run.published_at,
        "verification_pending": pending,
        "verifications": [asdict(each) for each in found],
    }


def published(run_id: int) -> RunView:
    """Return a run that is public; raises Problem if it is not, or no longer."""
    with services().database.reading() as session:
        found = publications.history(session, run_id)
    if found is not None and found.withdrawn_at is not None:
        on = datetime.fromtimestamp(found.withdrawn_at, UTC).date()
        raise Problem("withdrawn", f"Run {run_id} was withdrawn on {on}.")
    run = access.run_for(run_id)
    if not run.public:
        raise Problem("not-found", f"Run {run_id} has not been published.")
    return run

"""Publications: terms, permanent address and verifications."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from flask import Response, request
from flask_openapi3.blueprint import APIBlueprint
from flask_openapi3.models.tag import Tag

from seamark.server.api.requests.file_answers import answers_with
from seamark.server.api.requests.operation_ids import operation_id
from seamark.server.api.requests.schemas import RunPath
from seamark.server.api.runs.publication_schemas import PublicationResponse
from seamark.server.runs.leaderboard import leaderboard, score_counts
from seamark.server.runs.publication import badge, citations, publications
from seamark.server.runs.publication.citations import Citation
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.recomputation.verifications import Outcome
from seamark.server.runs.record.qualifier import qualifier
from seamark.server.runs.record.solutions import entry_name
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.showing.views import RunView
from seamark.server.web import access, caching
from seamark.server.web.citation import citation_of, result_of
from seamark.server.web.problems import Problem
from seamark.server.web.publication import address_of
from seamark.server.web.services import services

BADGE_S = 300  # for so long other sites and browsers keep a badge

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
        verified = verifications.of_run(session, run.id)
    return {
        "run": run.id,
        "address": address_of(run.id),
        "method": run.method,
        "author": run.user,
        "anonymous": run.anonymous,
        "program_public": run.program_public,
        "licence": run.licence,
        "published_at": run.published_at,
        "first_published_at": first.first_at if first else run.published_at,
        "verification_pending": pending,
        "verifications": [asdict(each) for each in verified],
    }


@api.get("/runs/<int:run_id>/citation.bib", responses=answers_with("application/x-bibtex"))
def citation_bib(path: RunPath) -> Response:
    """Download how a public run is cited with BibTeX or biblatex."""
    return _document(path.run_id, citations.bibtex, "application/x-bibtex; charset=utf-8")


@api.get("/runs/<int:run_id>/citation.cff", responses=answers_with("application/yaml", "object"))
def citation_cff(path: RunPath) -> Response:
    """Download the CITATION.cff (Citation File Format 1.2.0) of a public run."""
    return _document(path.run_id, citations.cff, "application/yaml; charset=utf-8")


@api.get("/runs/<int:run_id>/badge.svg", responses=answers_with("image/svg+xml"))
def badge_svg(path: RunPath) -> Response:
    """Show what a public run is, its method, score and rank as a badge, for pages elsewhere."""
    run = published(path.run_id)
    answer = Response(badge.svg(f"Seamark {run.benchmark}", _standing(run), qualifier(run)))
    answer.content_type = "image/svg+xml; charset=utf-8"
    answer.headers["Cross-Origin-Resource-Policy"] = "cross-origin"
    answer.cache_control.public, answer.cache_control.max_age = True, BADGE_S
    answer.add_etag()
    answer.make_conditional(request)
    return answer


def _document(run_id: int, write: Callable[[Citation], str], content_type: str) -> Response:
    run = published(run_id)
    answer = Response(write(citation_of(run)), content_type=content_type)
    answer.add_etag()
    return caching.conditional(answer)


def _standing(run: RunView) -> str:
    """Return method, score and rank in the words of a badge."""
    parts = [run.state.value if run.score is None else result_of(run)[1]]
    with services().database.reading() as session:
        mark = verifications.newest(session, [run.id]).get(run.id)
        if run.kind is RunKind.RANKED and run.user_id is not None:
            row = leaderboard.rank_of(session, run.benchmark, run.user_id)
            if row is not None and row.run_id == run.id and row.rank is not None:
                people = score_counts.size(session, run.benchmark)
                parts.append(f"rank {row.rank} of {people}")
    if mark is not None and mark.outcome is Outcome.AGREES:
        parts.append("verified")
    return f"{entry_name(run)}: {', '.join(parts)}"


def published(run_id: int) -> RunView:
    """Return a run that is public; raises Problem if it is not, or no longer."""
    with services().database.reading() as session:
        history = publications.history(session, run_id)
    if history is not None and history.withdrawn_at is not None:
        on = datetime.fromtimestamp(history.withdrawn_at, UTC).date()
        raise Problem("withdrawn", f"Run {run_id} was withdrawn on {on}.")
    run = access.known_run(run_id)  # a public one is for everybody
    if not run.public:
        raise Problem("not-found", f"Run {run_id} has not been published.")
    return run

"""The citation of a public run, with what the database and the settings know of it."""

from collections.abc import Mapping
from typing import Any

from seamark.server.accounts import profiles
from seamark.server.database.tables import User
from seamark.server.runs.publication import citations
from seamark.server.runs.publication.citations import ANONYMOUS, Author, Citation
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.showing.views import RunView
from seamark.server.web.publication import address_of
from seamark.server.web.services import services
from seamark.server.web.template_filters import score
from seamark.sim import registry


def citation_of(run: RunView) -> Citation:
    """Return the citation of a public run; of an anonymous one it names nobody."""
    with services().database.reading() as session:
        marks = verifications.of_run(session, run.id)
        user = None if run.anonymous or run.user_id is None else session.get(User, run.user_id)
        author = ANONYMOUS if user is None else _author(user)
    mark = marks[0] if marks else None
    result = " ".join(result_of(run))
    return citations.of_run(run, author, address=address_of(run.id), result=result, mark=mark)


def result_of(run: RunView) -> tuple[str, str]:
    """Return what the score of a run is called, and the score with its unit."""
    if run.benchmark not in registry.BENCHMARKS:  # of an earlier version
        return "Score", score(run.score)
    benchmark = registry.benchmark(run.benchmark)
    headline = benchmark.headline_of(benchmark.restore(run.config))
    return headline.label, f"{score(run.score)} {headline.unit}".strip()


def with_publication(manifest: Mapping[str, Any], run: RunView) -> dict[str, Any]:
    """Return the manifest of a run, of a public one with where and how it is published."""
    if not run.public:
        return dict(manifest)
    terms = {"address": address_of(run.id), "author": run.user, "licence": run.licence}
    return {**manifest, "publication": terms}


def _author(user: User) -> Author:
    profile = profiles.of(user)
    return Author(name=profile.public_name or user.name, affiliation=profile.affiliation)

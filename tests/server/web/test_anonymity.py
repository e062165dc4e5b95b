"""Whatever strangers can read while a run is published for review must not tell whose it is."""

import io
import zipfile
from collections.abc import Iterator

import pytest

from seamark.server.accounts import accounts, profiles
from seamark.server.accounts.profiles import Profile
from seamark.server.app import create_app
from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.publication import publications
from seamark.server.runs.publication.publications import Terms
from tests.cast import Backend
from tests.server.api.conftest import Site
from tests.server.web.routes import ROUTES

NAMES = ("zebedee", "Wombat Institute", "Zebedee Quill")
SECRETS = tuple(name.encode() for name in NAMES)


@pytest.fixture
def site(backend: Backend) -> Iterator[Site]:
    app = create_app(backend.settings)
    site = Site(backend.database, backend.settings, backend.viewers, app, headers={"guest": {}})
    yield site
    site.services.close()


def _for_review(site: Site) -> int:
    zebedee = site.sign_up("zebedee")
    assert zebedee.user_id is not None
    program = site.store_program(name="zebedees_best.py")
    run_id = site.succeeded("zebedee", kind="ranked", controller="upload", program=program)
    site.record(run_id, rows=40)
    earlier = site.succeeded("zebedee", kind="ranked")
    with site.database.writing() as session:
        profile = Profile(public_name="Zebedee Quill", affiliation="Wombat Institute")
        profiles.store(session, zebedee.user_id, profile)
        for each in (run_id, earlier):
            assert publications.publish(session, each, Terms(method="Steady hand", anonymous=True))
    return run_id


def _read(answer_data: bytes) -> Iterator[bytes]:
    """Yield what an answer holds, also below the compression of an archive."""
    yield answer_data
    if answer_data.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(answer_data)) as archive:
            yield from (archive.read(name) for name in archive.namelist())


@pytest.mark.slow
def test_no_address_that_strangers_can_read_tells_who_published_for_review(site: Site) -> None:
    run_id, told, read = _for_review(site), [], []

    for (method, route), entry in ROUTES.items():
        path = (entry.path or route).replace("{run}", str(run_id)).replace("{other}", str(run_id))
        if method != "GET" or "{" in path or path.endswith("/events"):
            continue
        with site.client().get(path, follow_redirects=True) as answer:
            shown = (*_read(answer.data), str(answer.headers).encode())
        read += [path] if answer.status_code == 200 else []
        if any(secret in part for part in shown for secret in SECRETS):
            told.append(path)

    assert told == []
    assert {f"/runs/{run_id}", f"/runs/{run_id}/embed", f"/api/v1/runs/{run_id}"} <= set(read)
    assert {"/", "/leaderboards/currents-v1", "/api/v1/leaderboards/currents-v1"} <= set(read)


@pytest.mark.slow
@pytest.mark.parametrize(
    "path",
    [
        "/api/v1/leaderboards/currents-v1?format=csv",
        "/api/v1/leaderboards/currents-v1?per=method",
        "/leaderboards/currents-v1?per=method",
        "/api/v1/leaderboards/currents-v1?limit=1",
        "/api/v1/runs?which=public",
        "/api/v1/runs?which=public&q=zebedee",
        "/benchmarks/currents-v1",
        "/compare?runs={run}",
        "/p/{run}",
    ],
)
def test_neither_do_lists_and_searches(site: Site, path: str) -> None:
    run_id = _for_review(site)

    answer = site.client().get(path.format(run=run_id), follow_redirects=True)

    shown = answer.data.replace(b"q=zebedee", b"")
    assert answer.status_code == 200
    assert not any(secret in shown for secret in (*SECRETS, b"zebedees_best"))


def test_who_runs_the_program_again_does_not_learn_what_its_author_called_it(site: Site) -> None:
    run_id = _for_review(site)
    with site.database.writing() as session:
        token = accounts.new_token(session, site.user_id("eva"), "reviews", ("read", "submit"))
    as_eva = {"Authorization": f"Bearer {token}"}

    form = site.client().get(f"/submit/currents-v1?from={run_id}", headers=as_eva)
    again = site.client().post(f"/api/v1/runs/{run_id}/rerun", headers=as_eva)

    assert (form.status_code, again.status_code) == (200, 202), again.text
    assert again.json is not None
    assert again.json["program_name"] == "program.py"
    assert b"zebedee" not in form.data


def test_neither_does_who_reads_why_a_program_failed(site: Site) -> None:
    zebedee = site.sign_up("zebedee")
    where = 'File "zebedees_best.py", line 3, in step'
    run_id = site.failed(
        {"message": "it failed", "traceback": where, "log_tail": [where]},
        who="zebedee",
        controller="upload",
        program=site.store_program(name="zebedees_best.py"),
    )
    site.record(run_id, rows=40)
    RunFiles(site.settings.data, run_id, 1).append_log(where.encode())
    with site.database.writing() as session:
        assert publications.publish(session, run_id, Terms(method="Steady hand", anonymous=True))

    paths = (f"/runs/{run_id}", *(f"/api/v1/runs/{run_id}{end}" for end in ("", "/log", "/events")))
    answers = {path: site.client().get(path) for path in paths}

    assert zebedee.user_id is not None
    assert {answer.status_code for answer in answers.values()} == {200}
    assert [path for path, answer in answers.items() if b"zebedee" in answer.data] == []
    assert b'File "****************", line 3' in answers[paths[2]].data


def test_the_profile_of_an_anonymous_author_lists_nothing(site: Site) -> None:
    _for_review(site)

    shown = site.client().get("/api/v1/users/zebedee").json

    assert shown is not None
    assert (shown["runs"], shown["ranks"]) == ([], [])


def test_whose_profile_is_empty_is_unknown_while_all_runs_are_anonymous(site: Site) -> None:
    quill = site.sign_up("quill")
    run_id = site.succeeded("quill", kind="ranked")
    with site.database.writing() as session:
        publications.publish(session, run_id, Terms(method="Steady hand", anonymous=True))

    assert quill.user_id is not None
    assert site.client().get("/users/quill").status_code == 404

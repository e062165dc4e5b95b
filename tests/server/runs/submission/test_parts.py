"""Runs with several programs: they are kept, claimed, run again and deleted together."""

from typing import Any

import pytest
from sqlalchemy import select

from seamark.programs import parts
from seamark.server.database.tables import Run, RunPart
from seamark.server.programs import check_queue, store
from seamark.server.programs.store import StoredProgram
from seamark.server.runs.data import retention
from seamark.server.runs.ending import account_deletion, deletion
from seamark.server.runs.publication.publications import PublicationRefused
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.submission.validation import AccountNeeded, SubmissionRejected
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import Backend
from tests.part_programs import BENCHMARK, C_DETECTOR, TRACKER


def stored(both: Backend) -> dict[str, StoredProgram]:
    return {
        "detector": both.store_program(C_DETECTOR, "find.c", "detector"),
        "tracker": both.store_program(TRACKER, "follow.py", "tracker"),
    }


def with_parts(both: Backend, **changes: Any) -> dict[str, Any]:
    """Return what a run of a built-in controller with both parts is queued with."""
    return {"benchmark": BENCHMARK, "controller": "chain", "parts": stored(both)} | changes


def rows_of(both: Backend, run_id: int) -> list[tuple[str, str, str | None, str]]:
    with both.database.reading() as session:
        rows = session.scalars(
            select(RunPart).where(RunPart.run_id == run_id).order_by(RunPart.role)
        )
        return [(row.role, row.program_sha256, row.program_name, row.language) for row in rows]


def is_used(both: Backend, program: StoredProgram) -> bool:
    with both.database.reading() as session:
        return check_queue.refers_to(session, program.sha256)


def test_a_run_shows_its_parts_and_hands_them_to_the_worker(both: Backend) -> None:
    run_id = both.queue("ann", **with_parts(both))

    shown = [(part.role, part.program_name, part.language) for part in both.show(run_id).parts]
    claim = both.claim(languages=("python", "c"))

    assert shown == [("detector", "find.c", "c"), ("tracker", "follow.py", "python")]
    assert claim is not None
    assert (claim.parts, claim.program_sha256) == (both.show(run_id).parts, None)


@pytest.mark.parametrize("languages", [(), ("python",), ("c",)])
def test_only_a_worker_that_runs_all_languages_gets_the_run(
    backend: Backend, languages: tuple[str, ...]
) -> None:
    backend.queue("ann", **with_parts(backend))

    assert backend.claim("w1", languages=languages) is None
    assert backend.claim("w2", languages=("c", "python")) is not None


@pytest.mark.parametrize(
    ("changes", "field", "sentence"),
    [
        (
            {"benchmark": "currents-v2", "controller": "pi"},
            "detector_program",
            "currents-v2 takes no program as its detector",
        ),
        ({"viewer": "guest"}, "detector_program", "Uploading a detector needs an account."),
    ],
)
def test_what_a_run_cannot_have_is_refused_at_its_field(
    backend: Backend, changes: dict[str, Any], field: str, sentence: str
) -> None:
    changes = {name: backend.viewers.get(str(one), one) for name, one in changes.items()}

    with pytest.raises(SubmissionRejected, match=sentence) as refused:
        backend.queue("ann", **with_parts(backend, **changes))

    assert refused.value.field == field


def test_an_account_is_needed_for_a_part(backend: Backend) -> None:
    with pytest.raises(AccountNeeded):
        backend.queue("guest", **with_parts(backend))


def test_a_language_that_cannot_have_the_role_is_refused(backend: Backend) -> None:
    fmu = StoredProgram("0" * 64, "model.fmu", "fmu", size=1)

    with pytest.raises(SubmissionRejected, match="FMU") as refused:
        backend.queue("ann", **with_parts(backend, parts={"tracker": fmu}))

    assert refused.value.field == parts.field("tracker")


def test_a_rerun_has_the_same_parts(backend: Backend) -> None:
    run_id = backend.queue("ann", **with_parts(backend))

    assert rows_of(backend, backend.rerun(run_id)) == rows_of(backend, run_id)


def test_a_run_whose_part_is_gone_cannot_run_again(backend: Backend) -> None:
    given = with_parts(backend)
    run_id = backend.queue("ann", **given)
    store.path(backend.settings, given["parts"]["tracker"].sha256).unlink()

    with pytest.raises(SubmissionRejected, match="The tracker of this run has been deleted"):
        backend.rerun(run_id)


def test_a_run_that_is_computed_again_has_the_same_parts(backend: Backend) -> None:
    run_id = backend.queue("ann", **with_parts(backend, kind="ranked"))

    with backend.database.writing() as session:
        original = session.get_one(Run, run_id)
        again = rejudged.enqueue(session, original, "rejudgement:1", backend.settings, draw=1)
        session.flush()
        again_id, seeds = again.id, (original.trial_seeds, again.trial_seeds)

    assert rows_of(backend, again_id) == rows_of(backend, run_id)
    assert seeds[0] != seeds[1]


def test_each_part_decides_the_fresh_seeds_and_its_name_does_not(backend: Backend) -> None:
    one, renamed = stored(backend), stored(backend)
    renamed["tracker"] = backend.store_program(TRACKER, "other.py", "tracker")
    runs = [
        backend.queue("ann", **with_parts(backend, kind="ranked", parts=given))
        for given in (one, renamed, {"tracker": one["tracker"]}, {})
    ]

    digests = [backend.show(run_id).submission for run_id in runs]

    assert digests[0] == digests[1]
    assert len(set(digests)) == 3


def test_a_ranked_run_refuses_the_settings_that_its_own_tracker_makes_void(
    backend: Backend,
) -> None:
    tracker = {"tracker": stored(backend)["tracker"]}
    given = with_parts(backend, kind="ranked", config={"tracker": "klt"})

    with pytest.raises(ConfigurationInvalid, match="has no effect"):
        backend.queue("ann", **given | {"parts": tracker})
    assert backend.queue("ann", **given | {"parts": {}})


def test_programs_of_parts_are_kept_as_long_as_the_data_of_the_run(both: Backend) -> None:
    given = with_parts(both)
    run_id = both.queue("ann", **given)
    assert both.cancel(run_id)
    tracker = given["parts"]["tracker"]
    assert is_used(both, tracker)

    assert retention.delete(both.database, both.settings, [run_id]) == [run_id]

    assert not is_used(both, tracker)


def test_a_deleted_run_keeps_no_name_of_a_part(both: Backend) -> None:
    run_id = both.queue("ann", **with_parts(both))
    assert both.cancel(run_id)

    assert deletion.delete(both.database, both.settings, [run_id]) == [run_id]

    assert [name for _role, _sha256, name, _language in rows_of(both, run_id)] == [None, None]


def test_no_part_outlives_a_deleted_account(both: Backend) -> None:
    both.queue("ann", **with_parts(both))
    last = both.queue("ann", **with_parts(both))
    with both.database.writing() as session:
        account_deletion.close(session, both.user_id("ann"), keep_published=False)

    while account_deletion.step(both.database, both.settings):
        pass

    with both.database.reading() as session:
        assert list(session.scalars(select(RunPart))) == []
        assert session.get_one(Run, last).owner == "deleted"


def published(both: Backend, **terms: Any) -> int:
    run_id = both.queue("ann", **with_parts(both))
    claim = both.claim(languages=("python", "c"))
    assert claim is not None
    assert both.finish(claim)
    return both.publish(run_id, **{"method": "Own eyes"} | terms)


def test_parts_are_published_as_a_program_is(backend: Backend) -> None:
    hidden = backend.show(published(backend, program=False))
    licensed = backend.show(published(backend, licence="MIT"))

    assert (hidden.program_public, licensed.program_public) == (False, True)
    assert licensed.licence == "MIT"


def test_a_method_with_own_parts_needs_a_name(backend: Backend) -> None:
    with pytest.raises(PublicationRefused, match="Name the method"):
        published(backend, method="")


def test_an_anonymous_run_does_not_show_what_its_author_called_the_parts(backend: Backend) -> None:
    run = backend.show(published(backend, anonymous=True))

    assert [part.program_name for part in run.parts] == ["program.c", "program.py"]
    assert set(run.hidden_names) == {"find.c", "follow.py"}

"""A competition in a record of currents that its organiser brings."""

import pytest
from sqlalchemy import select

from seamark.competitions.document import DocumentInvalid
from seamark.server.database.tables import Run
from seamark.server.judging import drafts, entries
from seamark.server.programs import own_files, store
from seamark.server.programs.own_files import StoredFile
from seamark.server.runs.data import retention, run_size
from seamark.server.runs.ending import deletion
from seamark.server.runs.queue.queue import Claim
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.sim.physics.water_motion import records
from tests.cast import Backend
from tests.server.judging.cup import NAME, Cup, values

SETTING = records.LIBRARY.setting


@pytest.fixture
def record(backend: Backend) -> StoredFile:
    return backend.store_record()


@pytest.fixture
def cup(backend: Backend, record: StoredFile) -> Cup:
    made = Cup.opened(backend, files=(record,))
    made.team("ann", "ben")
    return made


def files_of(backend: Backend, run_id: int) -> dict[str, str]:
    with backend.database.reading() as session:
        return {one.setting: one.sha256 for one in session.get_one(Run, run_id).files}


def next_claim(cup: Cup, run_id: int) -> Claim:
    """Return the claim of a worker that takes runs until it has this one."""
    while (claim := cup.backend.claim_next()).run_id != run_id:
        assert cup.backend.finish(claim)
    return claim


def test_the_record_of_a_draft_is_a_setting_of_its_document(
    backend: Backend, record: StoredFile
) -> None:
    draft = drafts.read(values(), backend.settings, files=(record,))
    with backend.database.writing() as session:
        drafts.create(session, backend.user_id("olga"), draft, backend.settings)
    cup = Cup.named(backend, NAME)

    assert cup.asked.settings[SETTING] == record.name
    assert cup.view.files == {SETTING: record.sha256}
    assert [files_of(backend, run_id) for run_id in cup.live()] == [
        {SETTING: record.sha256} for _ in cup.asked.base.baselines
    ]


def test_a_changed_draft_has_the_files_that_come_with_the_change(
    backend: Backend, record: StoredFile
) -> None:
    cup = Cup.draft(backend, files=(record,))
    for files, expected in (((record,), {SETTING: record.sha256}), ((), {})):
        changed = drafts.read(values(), backend.settings, files=files)
        with backend.database.writing() as session:
            drafts.change(session, cup.view, changed, backend.settings)
        assert cup.view.files == expected


def test_an_entry_runs_in_the_record_and_the_final_copies_it(cup: Cup, record: StoredFile) -> None:
    first = cup.submit("ann")
    claim = next_claim(cup, first)
    (file,) = claim.files

    assert claim.config[SETTING] == record.name
    assert (file.setting, file.sha256) == (SETTING, record.sha256)
    assert cup.backend.finish(claim)
    cup.entered("ben", [20.0, 21.0, 22.0], method="Other")
    final = cup.begin_final()
    assert final
    assert [files_of(cup.backend, run_id) for run_id in final] == [
        {SETTING: record.sha256} for _ in final
    ]


def test_no_team_chooses_another_record(cup: Cup) -> None:
    with pytest.raises(SubmissionRejected, match="fixes") as caught:
        cup.submit("ann", config={SETTING: "synthetic-ria"})
    assert caught.value.field == SETTING


def test_the_record_is_known_while_something_is_done_for_it_alone(
    cup: Cup, record: StoredFile
) -> None:
    run = cup.backend.show(cup.submit("ann"))
    settings = cup.backend.settings

    with own_files.lent_to(settings, run):
        assert records.LIBRARY.is_known(record.name)
    with entries.lent(cup.view, settings):
        assert records.LIBRARY.is_known(record.name)
    assert entries.fixed(cup.view, settings)[SETTING] == record.name
    assert not records.LIBRARY.is_known(record.name)


def test_the_record_stays_while_the_competition_is_there(cup: Cup, record: StoredFile) -> None:
    cup.entered("ann", [20.0, 21.0, 22.0])
    with cup.backend.database.reading() as session:
        runs = list(session.scalars(select(Run.id)))
    retention.delete(cup.backend.database, cup.backend.settings, runs)

    assert cup.backend.unused_deleted() == 0
    assert store.read(cup.backend.settings, record.sha256) == record.content


def test_the_record_goes_with_a_deleted_draft(backend: Backend, record: StoredFile) -> None:
    cup = Cup.draft(backend, files=(record,))
    assert backend.unused_deleted() == 0
    with backend.database.writing() as session:
        drafts.remove(session, cup.view)

    assert backend.unused_deleted() == 1


def test_a_run_again_has_the_record_until_it_is_deleted(cup: Cup, record: StoredFile) -> None:
    backend = cup.backend
    run_id = cup.entered("ann", [20.0, 21.0, 22.0])
    again = backend.rerun(run_id)

    assert files_of(backend, again) == {SETTING: record.sha256}
    assert backend.show(again).config[SETTING] == record.name
    (backend.settings.data / "programs" / record.sha256).unlink()
    with pytest.raises(SubmissionRejected, match="record of currents of this run"):
        backend.rerun(again)


def test_the_record_stays_for_a_run_that_has_its_data(backend: Backend, record: StoredFile) -> None:
    config: dict[str, object] = {SETTING: record.name}
    run_id = backend.queue(files=(record,), config=config)
    assert backend.finish(backend.claim_next())
    assert backend.unused_deleted() == 0

    deletion.delete(backend.database, backend.settings, [run_id])

    assert backend.unused_deleted() == 1


def test_the_space_of_a_record_counts_for_its_run(backend: Backend, record: StoredFile) -> None:
    config: dict[str, object] = {SETTING: record.name}
    with_record, without = backend.queue(files=(record,), config=config), backend.queue()
    sizes = [backend.show(run_id).data_bytes for run_id in (with_record, without)]

    assert sizes[0] == sizes[1] + len(record.content) * (1 + run_size.MANIFEST_SHARE)


def test_the_database_has_a_manifest_without_the_record_and_shows_it_with_it(
    backend: Backend, record: StoredFile
) -> None:
    run_id = backend.queue(files=(record,), config={SETTING: record.name})
    entry = {"sha256": record.sha256, "text": record.content.decode()}
    assert backend.finish(backend.claim_next(), manifest={"digest": "0", "current_file": entry})

    run = backend.show(run_id)

    assert run.manifest == {"digest": "0", "current_file": {"sha256": record.sha256}}
    whole = own_files.with_texts(run.manifest, run, backend.settings)
    assert whole["current_file"] == entry


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"settings": {"levels": [0.2], "level_duration_s": 300.0}}, "at least as long"),
        ({"benchmark": "visibility-v3", "settings": {}}, "no current record"),
    ],
)
def test_a_record_that_the_benchmark_cannot_use_is_refused(
    backend: Backend, record: StoredFile, changes: dict[str, object], sentence: str
) -> None:
    with pytest.raises(DocumentInvalid, match=sentence):
        drafts.read(values(**changes), backend.settings, files=(record,))

"""Vehicles of users in the store: bounded to read, kept with the run, and gone with it."""

import hashlib
import io
import time
import zipfile
from collections.abc import Iterator
from contextlib import closing

import pytest

from seamark.server.database.tables import Run
from seamark.server.programs import check_queue, own_files, store
from seamark.server.programs.reader import ProgramReader
from seamark.server.programs.vehicles import VehicleRejected
from seamark.server.runs.data import retention, run_size
from seamark.server.runs.downloads import export
from seamark.server.runs.ending import deletion
from seamark.server.runs.recomputation import rejudged
from seamark.server.runs.record import turns
from seamark.server.runs.submission.validation import SubmissionRejected
from seamark.sim.vehicles import is_known, own
from seamark.sim.vehicles.reading import HULL_MAX, SOLIDS_MAX, THRUSTERS_MAX
from seamark.sim.vehicles.toml_reading import BYTES_MAX
from tests.cast import VEHICLE, Backend
from tests.sim.vehicles.hostile_files import HOSTILE

SHA256 = hashlib.sha256(VEHICLE.encode()).hexdigest()
OWN_CPU_S = 0.2  # of the process that has a file read: the pipe, and the start of the next reader
LENT_CPU_S = 1.0  # 0.07 s where it was measured
OURS = {"vehicle": "bluerov2-heavy-v2"}
NAME = f"mine@{SHA256[:16]}"


def is_stored(backend: Backend) -> bool:
    return store.size(backend.settings, SHA256) > 0


def test_a_vehicle_is_stored_as_long_as_a_run_has_its_data(backend: Backend) -> None:
    run_id = backend.queue_vehicle()
    assert backend.unused_deleted() == 0
    assert backend.finish(backend.claim_next())
    assert (backend.unused_deleted(), is_stored(backend)) == (0, True)

    retention.delete(backend.database, backend.settings, [run_id])

    assert (backend.unused_deleted(), is_stored(backend)) == (1, False)
    assert backend.show(run_id).config["vehicle"] == NAME


def test_a_vehicle_goes_with_the_run_that_is_deleted(backend: Backend) -> None:
    run_id = backend.queue_vehicle()
    assert backend.finish(backend.claim_next())

    deletion.delete(backend.database, backend.settings, [run_id])

    assert backend.unused_deleted() == 1


def test_a_vehicle_of_a_check_is_kept(backend: Backend) -> None:
    vehicle, program = backend.store_vehicle(), backend.store_program()
    config = {"vehicle": vehicle.name}
    with backend.database.writing() as session:
        user_id = backend.user_id("ann")
        check_queue.enqueue(session, user_id, "currents-v2", config, program, vehicle)

    assert (backend.unused_deleted(), is_stored(backend)) == (0, True)


def test_a_run_whose_vehicle_was_deleted_is_not_run_again(backend: Backend) -> None:
    run_id = backend.queue_vehicle()
    assert backend.finish(backend.claim_next())
    retention.delete(backend.database, backend.settings, [run_id])
    backend.unused_deleted()

    with pytest.raises(SubmissionRejected, match="The vehicle of this run has been deleted"):
        backend.rerun(run_id)


def test_a_run_is_computed_again_with_its_vehicle(backend: Backend) -> None:
    run_id = backend.queue_vehicle()
    assert backend.finish(backend.claim_next())
    with backend.database.writing() as session:
        original = session.get_one(Run, run_id)
        rejudged.enqueue(session, original, rejudged.owner_of(1), backend.settings)
        turns.refresh(session, rejudged.owner_of(1))

    claim = backend.claim_next()

    assert (claim.config["vehicle"], claim.vehicle_sha256) == (NAME, SHA256)


def test_the_space_of_a_vehicle_counts_for_its_run(backend: Backend) -> None:
    with_vehicle, without = backend.queue_vehicle(), backend.queue(config=OURS)
    sizes = [backend.show(run_id).data_bytes for run_id in (with_vehicle, without)]

    uploaded = len(VEHICLE) * (1 + run_size.MANIFEST_SHARE)
    assert sizes[0] == sizes[1] + uploaded


def test_what_somebody_exports_has_their_vehicles(backend: Backend) -> None:
    run_id = backend.queue_vehicle()
    pieces = export.archive(
        backend.database, backend.settings, backend.viewers["ann"], telemetry=False
    )

    with zipfile.ZipFile(io.BytesIO(b"".join(pieces))) as archive:
        assert archive.read(f"runs/{run_id}/vehicle.toml") == VEHICLE.encode()


def test_the_database_has_a_manifest_without_the_file_and_shows_it_with_the_file(
    backend: Backend,
) -> None:
    run_id = backend.queue_vehicle()
    whole = {"digest": "0" * 64, "vehicle_file": {"sha256": SHA256, "text": VEHICLE}}
    assert backend.finish(backend.claim_next(), manifest=whole)

    run = backend.show(run_id)

    assert run.manifest == {"digest": "0" * 64, "vehicle_file": {"sha256": SHA256}}
    assert own_files.with_texts(run.manifest, run, backend.settings) == whole


def test_a_vehicle_is_known_while_something_is_done_for_its_run_alone(backend: Backend) -> None:
    run = backend.show(backend.queue_vehicle())

    with own_files.lent_to(backend.settings, run):
        assert is_known(NAME)
    assert not is_known(NAME)


def test_a_vehicle_that_was_changed_in_the_store_is_not_used(backend: Backend) -> None:
    run = backend.show(backend.queue_vehicle())
    file = backend.settings.data / "programs" / SHA256
    file.write_bytes(VEHICLE.replace('"Mine"', '"Theirs"').encode())

    with own_files.lent_to(backend.settings, run):
        assert not is_known(NAME)
    assert own_files.contents_of(run, backend.settings) == {}


@pytest.fixture(scope="module")
def reader() -> Iterator[ProgramReader]:
    with closing(ProgramReader()) as reader:
        yield reader


@pytest.mark.slow
@pytest.mark.parametrize("attack", HOSTILE)
def test_a_hostile_file_costs_this_process_nothing(reader: ProgramReader, attack: str) -> None:
    text = HOSTILE[attack]()
    content = text.encode() if isinstance(text, str) else text
    before = time.process_time()
    try:
        report, _content = reader.read_vehicle(io.BytesIO(content), "my.toml", owner="ann")
        refused = report.errors
    except VehicleRejected as refusal:
        refused = refusal.errors

    assert refused
    assert time.process_time() - before < OWN_CPU_S


@pytest.mark.slow
def test_the_largest_vehicle_that_is_accepted_is_known_within_a_moment(
    reader: ProgramReader,
) -> None:
    content = largest()
    report, _content = reader.read_vehicle(io.BytesIO(content), "my.toml", owner="ann")
    before = time.process_time()
    with own.lending(content) as name:
        first = time.process_time() - before
        assert name == report.name

    assert report.errors == ()
    assert first < LENT_CPU_S


def largest() -> bytes:
    """Return a vehicle that can run, with as many parts and bytes as are read."""
    note = f'unit = "m", tag = "E", reason = "{"x" * 390}"'
    axes = ("1.0, 0.0, 0.0", "0.0, 1.0, 0.0", "0.0, 0.0, 1.0")
    thrusters = (
        f'[[thrusters]]\nname = "t{at}"\ndirection = [{axes[at % 3]}]\n'
        f"position = {{ value = [{0.1 * (at % 5)}, {0.1 * (at % 7)}, 0.0], {note} }}\n"
        for at in range(THRUSTERS_MAX)
    )
    hull = (
        f'[[hull]]\nname = "h{at}"\ncentre = {{ value = [0.0, 0.0, 0.0], {note} }}\n'
        f"size = {{ value = [{0.01 * (at + 1)}, 0.2, 0.2], {note} }}\n"
        for at in range(HULL_MAX)
    )
    solid = (
        '{ shape = "box", size = [1.0, 1.0, 1.0], centre = [0.1, 0.0, 0.0], colour = "#f2b61d" }'
    )
    drawing = f"[drawing]\nsolids = [\n{(solid + chr(44) + chr(10)) * SOLIDS_MAX}]\n"
    text = "".join((VEHICLE, *thrusters, *hull, drawing))
    return (text + "# as many bytes as are read\n" * BYTES_MAX)[:BYTES_MAX].encode()

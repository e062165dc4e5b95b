"""A machine proves that it belongs to the service; one that computes otherwise gets no runs."""

import json
from pathlib import Path

import pytest
from sqlalchemy import update

from seamark.server.database.data_folder import DataFolder, WrongDataFolder
from seamark.server.database.result_code import difference, result_code
from seamark.server.database.schema import check_all, upgrade
from seamark.server.settings import SIGNS_NOTHING, Settings
from tests.cast import Backend


def _with_code(both: Backend, **changes: str) -> None:
    """Let another version have upgraded the database."""
    code = json.dumps(json.loads(result_code()) | changes, sort_keys=True)
    with both.database.writing() as session:
        session.execute(update(DataFolder).values(result_code=code))


def test_a_process_with_another_seed_key_does_not_start(both: Backend) -> None:
    other = both.settings.model_copy(update={"seed_key": "another one"})

    for start in (upgrade, lambda settings: check_all(settings, computes=True)):
        with pytest.raises(WrongDataFolder, match="ranked runs would get other seeds"):
            start(other)

    check_all(both.settings, computes=True)


def test_the_database_does_not_have_the_seed_key(both: Backend) -> None:
    with both.database.reading() as session:
        row = session.get_one(DataFolder, session.scalars(DataFolder.__table__.select()).one())

    assert row.seed_proof is not None
    assert both.settings.seed_key not in (row.mark, row.seed_proof, row.result_code)


def test_a_worker_with_other_code_or_libraries_does_not_start_and_is_told_why(
    both: Backend,
) -> None:
    _with_code(both, code="0" * 64, numpy="1.0")

    with pytest.raises(WrongDataFolder, match=r"it has other code, numpy \S+ instead of 1\.0\."):
        check_all(both.settings, computes=True)
    check_all(both.settings)  # a web process may be of the version before


def test_after_an_upgrade_an_older_worker_gets_no_run_and_after_its_return_it_does(
    both: Backend,
) -> None:
    run_id = both.queue()
    _with_code(both, code="0" * 64)
    none = both.claim()
    upgrade(both.settings)
    claim = both.claim()

    assert none is None
    assert claim is not None
    assert claim.run_id == run_id


def test_a_version_that_changes_pages_alone_computes_the_same() -> None:
    code = json.loads(result_code())

    assert "seamark" not in code
    assert difference(result_code(), json.dumps(code | {"numba": "1"})).startswith("numba ")


def test_a_worker_reads_no_session_secret(tmp_path: Path) -> None:
    settings = Settings.load(
        {"SEAMARK_DATA": str(tmp_path / "data"), "SEAMARK_SECRET_KEY": SIGNS_NOTHING}
    )

    assert settings.environment()["SEAMARK_SECRET_KEY"] == SIGNS_NOTHING
    assert not (tmp_path / "data" / "secret").exists()


def test_a_worker_draws_no_seed_key_and_starts_without_one(both: Backend, tmp_path: Path) -> None:
    worker = {"data": tmp_path / "worker", "secret_key": SIGNS_NOTHING}
    settings = Settings.model_validate(worker)

    assert not settings.derives_seeds
    assert list((tmp_path / "worker").iterdir()) == []
    check_all(both.settings.model_copy(update={"seed_key": settings.seed_key}), computes=True)


def test_a_worker_beside_the_data_folder_has_the_seed_key_of_it(both: Backend) -> None:
    (both.settings.data / "seed_key").write_text("the key")
    worker = {"data": both.settings.data, "secret_key": SIGNS_NOTHING}

    assert Settings.model_validate(worker).seed_key == "the key"

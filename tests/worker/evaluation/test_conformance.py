"""One law in every language: the same trajectory, bit for bit."""

import io
import zipfile
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import language_of
from seamark.sandbox.limits import Limits
from seamark.sandbox.probing.probes import probe
from seamark.sandbox.probing.self_test import why_not
from seamark.server.programs import starter_files, store
from seamark.server.settings import Settings
from seamark.worker.evaluation.local import Controller, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome
from tests.worker import built
from tests.worker.conftest import SHORT

pytestmark = pytest.mark.host

PROGRAMS = Path(__file__).parents[1] / "conformance"
TRACKER = Path(__file__).parents[1] / "conforming_trackers" / "differences.py"
SWEEP = {"sweep_to": 2.0, "sweep_step": 1.0, "level_duration_s": 3.0}
STRONG_CURRENT = SHORT | {"levels": [0.0, 0.6]}  # the reference meets its limit: anti-windup too


@pytest.fixture(scope="module")
def isolation() -> IsolationLevel:
    report = probe()
    if report.level < IsolationLevel.MEDIUM:
        pytest.skip(report.sentence())
    return report.level


def evaluated(
    controller: Controller,
    config: dict[str, object],
    isolation: IsolationLevel,
    trials: int = 1,
    benchmark: str = "currents-v1",
) -> RunOutcome:
    run = {"seed": 3, "trials": trials, "isolation": isolation}
    return evaluate_locally(benchmark, config, controller=controller, **run)


def skip_without(name: str, isolation: IsolationLevel) -> None:
    if why := missing(str(language_of(name)), isolation):
        pytest.skip(why)


@cache
def missing(language: str, isolation: IsolationLevel) -> str:
    return why_not(language, isolation)


@cache
def built_in_digest(isolation: IsolationLevel, heave: bool) -> str:
    return evaluated("pi", STRONG_CURRENT | {"control_heave": heave}, isolation).digest


@pytest.mark.parametrize(
    ("name", "heave"),
    [("pi.py", False), *((path.name, True) for path in sorted(PROGRAMS.iterdir()))],
)
def test_a_pi_in_another_language_gives_the_built_in_trajectory(name, heave, isolation) -> None:
    skip_without(name, isolation)
    config = STRONG_CURRENT | {"control_heave": heave}

    upload = evaluated(((PROGRAMS / name).read_bytes(), name), config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, heave)


@pytest.mark.parametrize("name", ["fmi2", "fmi3"])
def test_a_pi_as_an_fmu_gives_the_built_in_trajectory(name, isolation, tmp_path) -> None:
    skip_without("pi.fmu", isolation)
    config = STRONG_CURRENT | {"control_heave": True}

    program = store.prepare(built.fmu(name, tmp_path), "pi.fmu")
    upload = evaluated(program, config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, True)


def test_a_pi_exported_by_pythonfmu_gives_the_built_in_trajectory(isolation, tmp_path) -> None:
    skip_without("pi.fmu", isolation)
    made = FmuBuilder.build_FMU(built.FMUS / "pythonfmu_pi.py", dest=tmp_path)
    config = STRONG_CURRENT | {"control_heave": True}

    upload = evaluated(store.prepare(made.read_bytes(), "pi.fmu"), config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, True)


def test_the_largest_uploads_and_an_fmu_of_five_mib_get_into_a_box(isolation, tmp_path) -> None:
    skip_without("pi.fmu", isolation)
    most = Settings(data=tmp_path).upload_max_bytes
    assert most == Limits().source_kib << 10 == Limits().binary_mib << 20
    whole = io.BytesIO(built.fmu("fmi2", tmp_path))
    with zipfile.ZipFile(whole, "a") as archive:
        archive.writestr("resources/table.bin", np.random.default_rng(1).bytes(5 << 20))
    whole.seek(0)

    kept = store.save_upload(whole, "pi.fmu", limit=most, data=tmp_path)
    program = (store.read(tmp_path, kept.sha256), kept.name)
    upload = evaluated(program, STRONG_CURRENT | {"control_heave": True}, isolation)

    assert kept.size > 5 << 20
    assert upload.digest == built_in_digest(isolation, True)


def test_a_pi_as_embedded_coder_writes_it_gives_the_built_in_trajectory(isolation) -> None:
    skip_without("pi.c", isolation)
    config = STRONG_CURRENT | {"control_heave": True}
    files = {path.name: path.read_bytes() for path in built.MODEL.iterdir()}

    program = store.prepare(built.zipped(files), "pi.zip")
    upload = evaluated(program, config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, True)


def test_the_templates_give_one_trajectory_and_hold_station(isolation, tmp_path) -> None:
    outcomes = []
    for kind in starter_files.KINDS:
        name, source = next(iter(starter_files.start(kind).items()))
        if kind == "executable":
            (tmp_path / name).write_bytes(source)
            target = tmp_path / "controller.elf"
            name, source = target.name, built.compiled_here([tmp_path / name], target, "-static")
        skip_without(name, isolation)
        outcomes.append(evaluated((source, name), SHORT, isolation))

    assert {outcome.failure for outcome in outcomes} == {None}
    assert len({outcome.digest for outcome in outcomes}) == 1


@pytest.mark.parametrize("language", ["c", "c++", "matlab"])
def test_a_tracker_in_another_language_gives_the_trajectory_of_the_one_in_python(
    language, isolation
) -> None:
    name = starter_files.FILES["tracker"][language]
    skip_without(name, isolation)
    texts = {TRACKER.name: TRACKER.read_bytes()}
    texts[name] = starter_files.of(language, "tracker").encode()

    outcomes = [
        evaluated((text, file), SWEEP, isolation, benchmark="visibility-v1")
        for file, text in texts.items()
    ]

    assert [(outcome.failure, outcome.sentence) for outcome in outcomes] == [(None, "")] * 2
    assert outcomes[0].digest == outcomes[1].digest
    assert outcomes[0].metrics["overall"]["p5_percent"] > 50.0


def test_a_program_that_cannot_be_compiled_ends_the_run_with_its_line(isolation) -> None:
    skip_without("mine.c", isolation)

    outcome = evaluated(
        (b'#include "seamark.h"\nint x = y;\n', "mine.c"), SHORT, isolation, trials=2
    )

    assert outcome.failure == "compile_error"
    assert outcome.sentence.startswith("mine.c:2:9: error: 'y' undeclared")
    assert "int x = y;" in outcome.traceback

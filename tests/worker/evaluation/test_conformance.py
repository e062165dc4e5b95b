"""One law in every language: the same trajectory, bit for bit."""

import io
import zipfile
from contextlib import closing
from functools import cache

import numpy as np
import pytest
from pythonfmu.builder import FmuBuilder

from seamark.programs import preparation
from seamark.programs.preparation import PreparedProgram
from seamark.sandbox.compilation import compiled
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES, language_of, starters
from seamark.sandbox.languages.language import CONTROLLER, TRACKER
from seamark.sandbox.languages.sample import Sample
from seamark.sandbox.limits import Limits
from seamark.server.programs.reader import ProgramReader
from seamark.server.settings import Settings
from seamark.worker.evaluation.local import Controller, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome
from tests.sandbox import host_compiler
from tests.services.languages import skip_without
from tests.worker.conftest import SHORT
from tests.worker.evaluation.languages import built

pytestmark = pytest.mark.host

SAMPLES = [(name, sample) for name in LANGUAGES for sample in LANGUAGES[name].conformance]
CONTROLLERS = [each for each in SAMPLES if each[1].role == CONTROLLER]
TRACKERS = [each for each in SAMPLES if each[1].role == TRACKER]
SWEEP = {"sweep_to": 2.0, "sweep_step": 1.0, "level_duration_s": 3.0}
STRONG_CURRENT = SHORT | {"levels": [0.0, 0.6]}  # the reference meets its limit: anti-windup too


def evaluated(
    controller: Controller,
    config: dict[str, object],
    isolation: IsolationLevel,
    trials: int = 1,
    benchmark: str = "currents-v1",
) -> RunOutcome:
    run = {"seed": 3, "trials": trials, "isolation": isolation}
    return evaluate_locally(benchmark, config, controller=controller, **run)


@cache
def built_in_digest(isolation: IsolationLevel, heave: bool) -> str:
    return evaluated("pi", STRONG_CURRENT | {"control_heave": heave}, isolation).digest


def name_of(value: object) -> str:
    return value.upload_name if isinstance(value, Sample) else str(value)


def upload_of(language: str, sample: Sample, isolation: IsolationLevel) -> PreparedProgram:
    """Return a conformance program as it would be uploaded."""
    skip_without(language, isolation)
    known, content, name = LANGUAGES[language], sample.upload(), sample.upload_name
    if known.sample_compiler != language:
        content = compiled(known.sample_compiler, content, name, isolation=isolation)
        name = f"program{known.suffixes[0]}"
    return preparation.prepare(content, name, role=sample.role)


@pytest.mark.parametrize(("language", "sample"), CONTROLLERS, ids=name_of)
def test_a_pi_in_any_language_gives_the_built_in_trajectory(language, sample, isolation) -> None:
    program = upload_of(language, sample, isolation)

    outcome = evaluated(program, STRONG_CURRENT | {"control_heave": True}, isolation)

    assert (program.language, outcome.failure, outcome.sentence) == (language, None, "")
    assert outcome.digest == built_in_digest(isolation, True)


def test_controlling_heave_changes_the_trajectory(isolation) -> None:
    assert built_in_digest(isolation, False) != built_in_digest(isolation, True)


@pytest.mark.parametrize("name", ["fmi2", "fmi3"])
def test_a_pi_as_an_fmu_gives_the_built_in_trajectory(name, isolation, tmp_path) -> None:
    skip_without("fmu", isolation)
    config = STRONG_CURRENT | {"control_heave": True}

    program = preparation.prepare(host_compiler.fmu(name, tmp_path), "pi.fmu")
    upload = evaluated(program, config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, True)


def test_a_pi_exported_by_pythonfmu_gives_the_built_in_trajectory(isolation, tmp_path) -> None:
    skip_without("fmu", isolation)
    made = FmuBuilder.build_FMU(host_compiler.FMUS / "pythonfmu_pi.py", dest=tmp_path)
    config = STRONG_CURRENT | {"control_heave": True}

    upload = evaluated(preparation.prepare(made.read_bytes(), "pi.fmu"), config, isolation)

    assert (upload.failure, upload.sentence) == (None, "")
    assert upload.digest == built_in_digest(isolation, True)


def test_the_largest_uploads_and_an_fmu_of_five_mib_get_into_a_box(isolation, tmp_path) -> None:
    skip_without("fmu", isolation)
    most = Settings(data=tmp_path).upload_max_bytes
    assert most == Limits().source_kib << 10 == Limits().binary_mib << 20
    whole = io.BytesIO(host_compiler.fmu("fmi2", tmp_path))
    with zipfile.ZipFile(whole, "a") as archive:
        archive.writestr("resources/table.bin", np.random.default_rng(1).bytes(5 << 20))
    whole.seek(0)

    with closing(ProgramReader()) as reader:
        kept = reader.read_upload(whole, "pi.fmu", owner="ann", limit=most, role="controller")
    upload = evaluated(
        (kept.content, kept.name), STRONG_CURRENT | {"control_heave": True}, isolation
    )

    assert len(kept.content) > 5 << 20
    assert upload.digest == built_in_digest(isolation, True)


@pytest.mark.parametrize("language", starters())
def test_the_starter_of_every_language_is_the_built_in_pi(language, isolation, tmp_path) -> None:
    source, name = built(starters()[language], tmp_path)
    skip_without(str(language_of(name)), isolation)

    for heave in (False, True):
        outcome = evaluated((source, name), STRONG_CURRENT | {"control_heave": heave}, isolation)

        assert (outcome.failure, outcome.sentence) == (None, "")
        assert outcome.digest == built_in_digest(isolation, heave)


@cache
def first_tracker(isolation: IsolationLevel) -> RunOutcome:
    program = upload_of(*TRACKERS[0], isolation)
    return evaluated(program, SWEEP, isolation, benchmark="visibility-v1")


@pytest.mark.parametrize(("language", "sample"), TRACKERS[1:], ids=name_of)
def test_a_tracker_gives_one_trajectory_in_all_languages(language, sample, isolation) -> None:
    program = upload_of(language, sample, isolation)

    outcome = evaluated(program, SWEEP, isolation, benchmark="visibility-v1")

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == first_tracker(isolation).digest
    assert outcome.metrics["overall"]["p5_percent"] > 50.0


def test_a_program_that_cannot_be_compiled_ends_the_run_with_its_line(isolation) -> None:
    skip_without("c", isolation)

    outcome = evaluated(
        (b'#include "seamark.h"\nint x = y;\n', "mine.c"), SHORT, isolation, trials=2
    )

    assert outcome.failure == "compile_error"
    assert outcome.sentence.startswith("mine.c:2:9: error: 'y' undeclared")
    assert "int x = y;" in outcome.traceback

"""A language is a folder and a line in the registry: one is added from a temporary folder."""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

from seamark.programs import preparation
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES, editor_starters, language_of, starters
from seamark.sandbox.languages.language import Language
from seamark.sandbox.probing.self_test import tried
from seamark.worker.evaluation.local import evaluate_locally
from tests.worker.conftest import SHORT

pytestmark = pytest.mark.host

# A language of formulas: one line of Python for each axis.
HOST = """
from pathlib import Path

from seamark.sandbox.languages.language import Calls, Language
from seamark.sandbox.languages.sample import sample
from seamark.sandbox.languages.script_runtime import script_runtime

HERE = Path(__file__).parent


def runtime():
    return script_runtime(HERE / "inside", "runner", environment={"LANG": "C.UTF-8"})


FORMULAS = Language(
    name="formulas",
    label="Formulas",
    suffixes=(".formulas",),
    runtime=runtime,
    calls=Calls("The formulas", "the reset", "the formulas"),
    self_test=sample(HERE / "self_test.formulas"),
    starters=(sample(HERE / "starter.formulas"),),
    conformance=(sample(HERE / "p.formulas"),),
)
"""
INSIDE = """
import math, struct, sys

from ...inside.connection import connected
from ...inside.port_names import observation_spans


def main():
    connection = connected(sys.argv[sys.argv.index("--") + 1 :])
    connection.send(b"k")
    header, source = connection.program()
    formulas = [compile(line, "formulas", "eval") for line in source.decode().splitlines()]
    spans = observation_spans(header["layout"])
    connection.send(b"k")
    while True:
        letter, body = connection.receive()
        if letter == b"Q":
            connection.quit()
        if letter == b"R":
            connection.send(b"k")
            continue
        values = struct.unpack(f"<{len(body) // 8}d", body)
        names = header["config"] | {name: values[span.offset] for name, span in spans.items()}
        answers = [eval(one, {"min": min, "max": max}, names) for one in formulas]
        connection.send(b"c", struct.pack(f"<{len(answers)}d", *answers))
"""
AXIS = "min(max(kp * {}, -reference_limit_m_s), reference_limit_m_s)\n"
FILES = {
    "__init__.py": HOST,
    "inside/__init__.py": "",
    "inside/runner.py": INSIDE,
    "self_test.formulas": "".join(f"0.5 * error_{axis}\n" for axis in "xyz") + "0.0\n",
    "starter.formulas": "0.5 * error_x\n0.5 * error_y\n0.5 * error_z\n0.0\n",
    "p.formulas": "".join(AXIS.format(f"error_{axis}") for axis in "xyz") + "0.0\n",
}


@pytest.fixture
def formulas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Language:
    folder = tmp_path / "formulas"
    (folder / "inside").mkdir(parents=True)
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    for path in (*folder.parents, folder, folder / "inside"):  # as a checkout that boxes can enter
        if path.stat().st_uid == os.geteuid() and path.is_relative_to(tmp_path):
            path.chmod(0o755)
    spec = importlib.util.spec_from_file_location("formulas", folder / "__init__.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "formulas", module)
    spec.loader.exec_module(module)
    monkeypatch.setitem(LANGUAGES, module.FORMULAS.name, module.FORMULAS)  # the registry line
    return module.FORMULAS


def test_it_passes_its_self_test_and_is_offered_where_languages_are_listed(
    formulas: Language, isolation: IsolationLevel
) -> None:
    assert tried("formulas", isolation).why_not == ""
    assert language_of("mine.formulas") == "formulas"
    assert "formulas" in starters()
    assert "formulas" in editor_starters("controller")


def test_its_conformance_program_gives_the_trajectory_of_the_built_in_controller(
    formulas: Language, isolation: IsolationLevel
) -> None:
    sample = formulas.conformance[0]
    config = SHORT | {"levels": [0.0, 0.6], "control_heave": True}
    run = {"seed": 3, "trials": 1, "isolation": isolation}

    program = preparation.prepare(sample.upload(), sample.upload_name)
    outcome = evaluate_locally("currents-v1", config, controller=program, **run)
    built_in = evaluate_locally("currents-v1", config, controller="p", **run)

    assert (outcome.failure, outcome.sentence) == (None, "")
    assert outcome.digest == built_in.digest

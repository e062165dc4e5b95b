"""`seamark competition audit`: says what it checked, and by its exit code whether that is right."""

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner, Result

from seamark.cli.main import cli
from seamark.sim import registry
from seamark.sim.physics.water_motion import records
from seamark.worker.evaluation.local import evaluate_locally
from tests.cast import RECORD
from tests.seamark.competitions.audits import document


def audited(folder: Path, content: bytes, *options: str) -> Result:
    (folder / "audit.json").write_bytes(content)
    arguments = ["competition", "audit", str(folder / "audit.json"), *options]
    return CliRunner().invoke(cli, arguments)


def changed(**values: Any) -> bytes:
    return json.dumps(document() | values).encode()


def test_a_sound_file_is_said_to_be_sound(tmp_path: Path) -> None:
    result = audited(tmp_path, changed())

    assert result.exit_code == 0
    assert "good    Round 3 (final): the standings of 4 entries follow" in result.stdout
    assert result.stdout.endswith("\nNothing is wrong with what can be checked.\n")


def test_what_is_wrong_is_printed_with_exit_code_1(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(frozen_sha256="0" * 64))

    assert result.exit_code == 1
    assert result.stdout.startswith("problem The frozen document does not have the SHA-256")
    assert "\n1 of 19 checks found something wrong; see above.\n" in result.stdout


def test_warnings_alone_leave_a_file_sound(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(standings=None), "--json")

    assert result.exit_code == 0
    told = json.loads(result.stdout)
    assert told["sound"] is True
    assert told["findings"][-1] == {
        "level": "warning",
        "sentence": "Round 3 (final): it has no standings yet.",
    }


def test_json_says_what_is_wrong(tmp_path: Path) -> None:
    result = audited(tmp_path, changed(frozen={}), "--json")

    assert result.exit_code == 1
    told = json.loads(result.stdout)
    assert told["sound"] is False
    assert told["findings"][0]["level"] == "problem"


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"PK", "Error: audit.json is no audit file: the file is no JSON: "),
        (changed(title=5), "Error: audit.json cannot be checked: the document: title is no "),
    ],
)
def test_a_file_of_another_kind_is_refused(tmp_path: Path, content: bytes, sentence: str) -> None:
    result = audited(tmp_path, content)

    assert result.exit_code == 2
    assert result.stderr.startswith(sentence)


@pytest.fixture(scope="module")
def with_run() -> dict[str, Any]:
    """An audit in which run 7 of the built-in PI, of two short trials, is all of the entries."""
    benchmark = registry.benchmark("currents-v1")
    short = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0, "score": "2 * score"}
    config = benchmark.read(short).model_dump(mode="json")
    outcome = evaluate_locally("currents-v1", config, seed=5, trials=2, controller="pi")
    assert outcome.metrics is not None
    submitted = {"benchmark": "currents-v1", "configuration": config, "controller": "pi"}
    scores = [2.0 * trial["score"] for trial in outcome.metrics["trials"]]
    run = {"run": 7, "seed": 5, "scores": scores, "digest": outcome.digest}
    return document() | {"entries": [document()["entries"][0] | run | {"submitted": submitted}]}


def recomputed(folder: Path, audit: dict[str, Any]) -> dict[str, str]:
    """Return the last finding of an audit whose runs are computed again."""
    result = audited(folder, json.dumps(audit).encode(), "--recompute", "--json")
    last: dict[str, str] = json.loads(result.stdout)["findings"][-1]
    return last


def of_run(audit: dict[str, Any], **values: Any) -> dict[str, Any]:
    return audit | {"entries": [audit["entries"][0] | values]}


@pytest.mark.slow
def test_a_run_of_a_built_in_solution_comes_out_the_same(
    with_run: dict[str, Any], tmp_path: Path
) -> None:
    digest = with_run["entries"][0]["digest"]

    assert recomputed(tmp_path, with_run) == {
        "level": "good",
        "sentence": f"Run 7 (PI, round 1), computed again, is the same: {digest}.",
    }


@pytest.mark.slow
@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"digest": "0" * 64}, "instead of 0000"),
        ({"seed": 6}, "has the digest "),
        ({"scores": [0.0, 0.0]}, "computed again, has other scores in 2 of 2 trials."),
    ],
)
def test_a_run_that_comes_out_otherwise_is_a_problem(
    values: dict[str, Any], sentence: str, with_run: dict[str, Any], tmp_path: Path
) -> None:
    found = recomputed(tmp_path, of_run(with_run, **values))

    assert found["level"] == "problem"
    assert sentence in found["sentence"]


@pytest.mark.parametrize(
    ("submitted", "sentence"),
    [
        ({"program": "ab" * 32}, "No run was computed again: each needs a program."),
        ({"parts": {"tracker": []}}, "No run was computed again: each needs a program."),
        ({"controller": "other"}, "No run was computed again: each needs a program."),
        ({"configuration": {"levels": "x"}}, "Run 7 (PI, round 1) cannot be computed again here: "),
    ],
)
def test_a_run_that_cannot_be_computed_here_is_said(
    submitted: dict[str, Any], sentence: str, with_run: dict[str, Any], tmp_path: Path
) -> None:
    other = with_run["entries"][0]["submitted"] | submitted

    found = recomputed(tmp_path, of_run(with_run, submitted=other))

    assert found["level"] == "warning"
    assert found["sentence"].startswith(sentence)


@pytest.mark.slow
def test_a_run_in_the_organisers_record_is_computed_with_the_file_in_the_audit(
    tmp_path: Path,
) -> None:
    short = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0}
    with records.LIBRARY.lending(RECORD.encode()) as name:
        config = registry.benchmark("currents-v1").read(short | {"current_record": name})
        values = config.model_dump(mode="json")
        outcome = evaluate_locally("currents-v1", values, seed=5, trials=2, controller="pi")
    assert outcome.metrics is not None
    submitted = {"benchmark": "currents-v1", "configuration": values, "controller": "pi"}
    run = {"run": 7, "seed": 5, "digest": outcome.digest, "submitted": submitted}
    run["scores"] = [trial["score"] for trial in outcome.metrics["trials"]]
    audit = of_run(document(), **run)

    without = recomputed(tmp_path, audit | {"files": {}})
    broken = recomputed(tmp_path, audit | {"files": {"current_record": "x"}})
    whole = recomputed(tmp_path, audit)

    assert (without["level"], broken["level"]) == ("warning", "problem")
    assert without["sentence"].startswith("Run 7 (PI, round 1) cannot be computed again here: ")
    assert broken["sentence"].startswith("The file of the setting current_record cannot be used:")
    assert whole["sentence"].endswith(f"computed again, is the same: {outcome.digest}.")


def test_runs_of_a_benchmark_of_a_later_version_are_not_computed(tmp_path: Path) -> None:
    found = recomputed(tmp_path, document() | {"benchmark": "currents-v99"})

    assert found["sentence"] == (
        "No run was computed again: there is no benchmark currents-v99 here."
    )

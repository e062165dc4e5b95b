"""Runs with further programs through a worker: its boxes, its log, its verdicts."""

import pytest

from seamark.server.programs.store import StoredProgram
from seamark.sim import registry
from tests.part_programs import BENCHMARK, C_DETECTOR, DETECTOR, TRACKER
from tests.worker.conftest import Service

pytestmark = [pytest.mark.host, pytest.mark.slow]

QUICK = dict(registry.benchmark(BENCHMARK).quick_settings) | {"loop1_values": [0.2]}
SLEEPER = DETECTOR.replace(b"return []", b"__import__('time').sleep(1e6)")
SPINNER = DETECTOR.replace(b"return []", b"while True: pass")
CRASHING = C_DETECTOR.replace(b"return 0;", b"volatile int *nothing = 0; return *nothing;")


def submitted(service: Service, parts: dict[str, StoredProgram], **changes: object) -> int:
    run = {"benchmark": BENCHMARK, "controller": "chain", "trials": 2} | changes
    return service.submit(QUICK, parts=parts, **run)


def test_parts_in_two_languages_take_part_in_all_trials(running: Service) -> None:
    parts = {
        "detector": running.store_program(C_DETECTOR, "find.c", "detector"),
        "tracker": running.store_program(TRACKER, "follow.py", "tracker"),
    }

    run = running.ended(submitted(running, parts))

    assert run.state == "succeeded", run.detail
    assert run.manifest is not None
    digests = {role: program.sha256 for role, program in parts.items()}
    assert run.manifest["parts"] == digests
    assert run.isolation is not None


def test_an_uploaded_controller_and_its_detector_have_one_log(running: Service) -> None:
    parts = {"detector": running.store_program(DETECTOR, "find.py", "detector")}
    arm = b"""
class Controller:
    def __init__(self, config):
        print("steering")

    def reset(self, level): ...

    def step(self, observation):
        return [0.0] * (4 + len(observation.joints))
"""
    program = running.store_program(arm, "steer.py")

    run = running.ended(submitted(running, parts, controller="upload", program=program))

    assert run.state == "succeeded", run.detail
    log = running.files(run.id).log_text()
    assert log.count("[controller]\nsteering\n") == 2
    assert log.count("[detector]\nlooking for SEAMARK\n") == 2


@pytest.mark.parametrize(
    ("source", "name", "cause", "sentence"),
    [
        # Twice it may have been starved, which takes ten seconds each time.
        pytest.param(
            *(SLEEPER, "find.py", "time_limit"),
            "The detector: detect(image) did not return within",
            marks=pytest.mark.long,
        ),
        (SPINNER, "find.py", "time_limit", "The detector: detect(image) used"),
        (CRASHING, "find.c", "user_error", "The detector was ended by SIGSEGV"),
    ],
)
def test_a_hostile_part_ends_the_run_by_its_name_and_the_next_one_starts(
    running: Service, source: bytes, name: str, cause: str, sentence: str
) -> None:
    hostile = {"detector": running.store_program(source, name, "detector")}

    run = running.ended(submitted(running, hostile))

    assert (run.state, run.cause) == ("failed", cause)
    assert run.detail["sentence"].startswith(sentence)
    assert running.ended(submitted(running, {}, trials=1)).state == "succeeded"

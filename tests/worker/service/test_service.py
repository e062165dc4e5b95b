"""The whole way of a run, with the real broker, worker, simulator and sandbox."""

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Iterator

import pytest

from seamark.sandbox.languages import LANGUAGES, editor_starters
from seamark.server.database.tables import Run
from seamark.server.messaging import broker
from seamark.server.runs.record.states import RunState
from seamark.server.runs.submission import quota, submission, validation
from seamark.server.runs.submission.validation import Submission
from seamark.server.web.streams.hub import Hub
from seamark.sim.recording.telemetry import INDEX, digest
from seamark.worker.evaluation.local import evaluate_locally
from tests.services.viewer import Viewer
from tests.worker.conftest import LONG, SHORT, Service

pytestmark = [pytest.mark.slow, pytest.mark.host]

UPLOADED_P = """
class Controller:
    def __init__(self, config):
        print("gains", config["kp"])
        self.kp, self.limit = config["kp"], config["reference_limit_m_s"]
    def reset(self, level):
        pass
    def step(self, observation):
        u, v = (min(max(self.kp * e, -self.limit), self.limit) for e in observation.error[:2])
        return [u, v, 0.0, 0.0]
"""
VISIBILITY = {"sweep_to": 0.5, "sweep_step": 0.5, "level_duration_s": 2.0}
STEP = "class Controller:\n def __init__(s, c): pass\n def reset(s, l): pass\n def step(s, o):\n"
PROGRAMS = {
    "user_error": STEP + "  return [1 / 0, 0, 0, 0]\n",
    "compile_error": STEP + "  return [0, 0, 0, 0]\nreturn\n",
    "protocol_error": STEP + "  return [float('nan'), 0, 0, 0]\n",
    "time_limit": STEP + "  while True: pass\n",
    # When it is constructed, not in a step: memory can be slower than the 2 s of an answer.
    "memory_limit": "class Controller:\n def __init__(s, c):\n"
    "  s.all = [bytearray(1 << 20) for _ in range(4000)]\n"
    " def reset(s, l): pass\n def step(s, o): return [0, 0, 0, 0]\n",
    "output_limit": STEP + "  print('x' * (1 << 23))\n  return [0, 0, 0, 0]\n",
    "process_limit": STEP
    + "  import threading as t\n"
    + "  for _ in range(100): t.Thread(target=t.Event().wait, daemon=True).start()\n"
    + "  return [0, 0, 0, 0]\n",
}
OUTSIDE = {  # what a program must not reach -> the error that it gets
    "open('/etc/shadow')": "FileNotFoundError",
    "__import__('socket').create_connection(('192.0.2.1', 80))": "PermissionError",
}
# As earlier versions named the tasks; their tickets may wait in a broker that was kept.
EARLIER_TASKS = (
    "worker.tasks.work",
    "worker.tasks.sweep",
    "seamark.worker.service.tasks.work",
    "seamark.worker.service.tasks.sweep",
)
PI = LANGUAGES["python"].conformance[0].files["controller.py"]
PI_C = LANGUAGES["c"].conformance[0].files["controller.c"]


def _here(controller: str) -> str:
    outcome = evaluate_locally("currents-v1", SHORT, seed=3, controller=controller)
    return outcome.digest


def test_trackers_give_the_server_the_bytes_of_a_local_run_too(running: Service) -> None:
    source = editor_starters("tracker")["python"].text()
    order = {"benchmark": "visibility-v1", "config": VISIBILITY}
    wanted = evaluate_locally("visibility-v1", VISIBILITY, seed=3, controller="built-in")
    program = running.store_program(source.encode(), role="tracker")
    built_in = running.submit(controller="built-in", **order)
    upload = running.submit(controller="upload", program=program, **order)

    ours, theirs = (running.ended(run_id) for run_id in (built_in, upload))

    assert (ours.state, theirs.state) == (RunState.SUCCEEDED, RunState.SUCCEEDED)
    assert ours.digest == wanted.digest
    assert digest(running.files(upload).rows()) == theirs.digest
    assert theirs.score == 1.0  # the level after the last: it fails at none


def test_the_server_gives_the_bytes_of_a_local_run(running: Service) -> None:
    wanted = {"p": _here("p"), "pi": _here("pi"), "upload": _here("p")}
    made = {
        "p": running.submit(controller="p"),
        "pi": running.submit(controller="pi"),
        "upload": running.submit_program(UPLOADED_P),
    }
    views = {name: running.ended(run_id) for name, run_id in made.items()}

    assert {name: view.state for name, view in views.items()} == dict.fromkeys(
        made, RunState.SUCCEEDED
    )
    assert {name: view.digest for name, view in views.items()} == wanted
    for view in views.values():
        files = running.files(view.id)
        assert digest(files.rows()) == view.digest
        assert (files.manifest() or {})["digest"] == view.digest
        assert (files.metrics() or {})["score"] == view.score
    assert "gains" in running.files(made["upload"]).log_text()


def test_the_server_compiles_a_program_and_gives_the_bytes_of_a_local_run(
    running: Service,
) -> None:
    program = running.store_program(PI_C.read_bytes(), PI_C.name)

    view = running.ended(running.submit(controller="upload", program=program))

    assert (view.state, view.language) == (RunState.SUCCEEDED, "c")
    assert view.digest == _here("pi")


@pytest.fixture
def load() -> Iterator[None]:
    """Four processes that do nothing but compute."""
    command = [sys.executable, "-S", "-c", "while True: pass"]
    busy = [subprocess.Popen(command) for _ in range(4)]
    yield
    for process in busy:
        process.kill()
        process.wait()


@pytest.fixture
def elsewhere() -> str:
    """The digest that the command line gives, in a process with another seed for hashes."""
    values = ("levels=0,0.2", "level_duration_s=4", "settle_s=1")
    settings = [word for value in values for word in ("--set", value)]
    arguments = ["run", "currents-v1", "--controller", str(PI), "--seed", "3", "--json", *settings]
    answer = subprocess.run(
        [sys.executable, "-m", "seamark.cli.main", *arguments],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONHASHSEED": "7"},
        check=True,
    )
    return str(json.loads(answer.stdout)["digest"])


def test_the_bytes_are_those_of_the_command_line_under_load_and_beside_another_run(
    running: Service, elsewhere: str, load: None
) -> None:
    queued = [
        running.submit(controller="pi"),
        running.submit_program(PI.read_text(encoding="utf-8")),
    ]
    in_this_process = evaluate_locally("currents-v1", SHORT, seed=3, controller="pi")

    digests = [running.ended(run_id).digest for run_id in queued]

    assert {elsewhere, in_this_process.digest, *digests} == {elsewhere}


def test_every_bad_program_gets_its_failure_reason_with_a_remedy(running: Service) -> None:
    made = {}
    views = {}
    for cause, source in PROGRAMS.items():
        made[cause] = running.submit_program(source)
        views[cause] = running.ended(made[cause])

    assert {cause: view.cause for cause, view in views.items()} == {
        cause: cause for cause in PROGRAMS
    }
    for view in views.values():
        assert view.state is RunState.FAILED
        assert view.detail["title"]
        assert view.detail["sentence"]
        assert view.detail["remedy"]
        assert view.attempt == 1
    assert "line 5" in views["user_error"].detail["traceback"]


def test_a_program_that_reaches_outside_gets_an_error_and_a_remedy(running: Service) -> None:
    for reach, error in OUTSIDE.items():
        view = running.ended(running.submit_program(f"{STEP}  {reach}\n  return [0, 0, 0, 0]\n"))

        assert (view.state, view.cause) == (RunState.FAILED, "user_error")
        assert view.detail["sentence"].startswith(error)
        assert "no network" in view.detail["remedy"]
    assert running.ended(running.submit()).state is RunState.SUCCEEDED


def test_a_configuration_that_became_invalid_ends_at_once_and_blames_no_program(
    running: Service,
) -> None:
    with running.database.writing() as session:
        order = Submission(
            viewer=running.viewers["ann"], benchmark="currents-v1", config=SHORT, controller="pi"
        )
        valid = validation.validate(order, running.settings)
        run_id = submission.submit(session, valid, running.settings)
        # As an update of the software leaves it that has narrowed a range.
        session.get_one(Run, run_id).config = {"kp": 99.0}
    assert broker.send_tickets(running.app)

    view = running.ended(run_id)

    assert (view.state, view.cause, view.attempt) == (RunState.FAILED, "benchmark_error", 1)
    assert "Kp" in view.detail["sentence"]


def test_a_failure_of_the_platform_is_retried_twice_and_not_charged_to_the_program(
    running: Service,
) -> None:
    program = running.store_program(UPLOADED_P.encode())
    for path in (running.settings.data / "programs").iterdir():
        path.unlink()

    view = running.ended(running.submit(SHORT, controller="upload", program=program))

    assert (view.state, view.cause, view.attempt) == (RunState.FAILED, "platform_error", 3)
    assert "FileNotFoundError" not in str(view)


def test_a_running_run_is_cancelled_within_two_seconds_and_keeps_its_data(
    running: Service,
) -> None:
    run_id = running.submit(LONG, trials=10)
    running.wait(run_id, lambda view: view.t_simulated > 0)

    view, seconds = running.time_to_cancel(run_id)

    assert view.state is RunState.CANCELLED
    assert seconds < 2.0
    assert running.files(run_id).row_count() > 0
    after = running.submit()
    assert running.ended(after).state is RunState.SUCCEEDED


def test_tickets_of_earlier_versions_do_no_harm(running: Service) -> None:
    for name in EARLIER_TASKS:
        running.app.send_task(name)

    view = running.ended(running.submit())

    assert view.state is RunState.SUCCEEDED
    assert running.settled()  # no ticket waits or comes back


def test_live_events_show_the_state_the_telemetry_the_log_and_the_end(running: Service) -> None:
    hub = Hub(running.database, running.settings)
    run_id = running.submit_program(UPLOADED_P)
    viewer = Viewer(hub, run_id, after="1-0-0")

    asyncio.run(viewer.watch())
    hub.close()

    assert viewer.events("state")[-1]["state"] == "succeeded"
    assert len(viewer.events("end")) == 1
    assert viewer.log() == running.files(run_id).log().text
    assert viewer.times()[-1] == running.files(run_id).rows()[-1, INDEX["t"]]
    assert viewer.times() == sorted(viewer.times())


def test_a_check_is_answered_while_long_runs_occupy_all_slots(running: Service) -> None:
    run_id = running.submit(LONG, trials=10)
    running.wait(run_id, lambda view: view.t_simulated > 0)

    answer = running.check(UPLOADED_P.encode())

    assert (answer["ok"], answer["problems"]) == (True, [])
    assert (answer["step_us"]["count"], answer["output"][:5]) == (40, "gains")
    assert running.show(run_id).state is RunState.RUNNING
    assert running.cancel(run_id)


@pytest.mark.parametrize(
    ("step", "stage", "sentence", "line"),
    [
        ("  return [0, 0]\n", "run", "step returned 2 values", 4),
        ("  return [1 / 0, 0, 0, 0]\n", "run", "ZeroDivisionError", 5),
        ("  while True: pass\n", "run", "CPU time", None),
        ("  return [0, 0, 0, 0]\nraise ValueError('at once')\n", "start", "at once", 6),
        ("  return [0, 0, 0, 0]\nreturn\n", "compile", "outside function", 6),
    ],
)
def test_a_check_names_what_is_wrong_with_its_line(
    running: Service, step: str, stage: str, sentence: str, line: int | None
) -> None:
    answer = running.check((STEP + step).encode())

    [problem] = answer["problems"]
    assert (answer["ok"], problem["stage"], problem["line"]) == (False, stage, line)
    assert sentence in problem["sentence"]


def test_a_check_of_c_shows_each_message_of_the_compiler(running: Service) -> None:
    source = b'#include "seamark.h"\nint f(void) { return nothing; }\nint g(void) { return 1 }\n'

    answer = running.check(source, "mine.c")

    locations = [(p["stage"], p["file"], p["line"]) for p in answer["problems"]]
    assert locations == [("compile", "mine.c", 2), ("compile", "mine.c", 3)]


def test_a_check_leaves_no_run_and_takes_nothing_of_the_quota(running: Service) -> None:
    with running.database.reading() as session:
        before = quota.used_by(session, running.viewers["ann"], running.settings)

    running.check(UPLOADED_P.encode())

    with running.database.reading() as session:
        assert quota.used_by(session, running.viewers["ann"], running.settings) == before

"""The playback attack, end to end: a table of what was seen in an earlier ranked run gains nothing.

Everything is real: uploads by the HTTP interface, the queue, a worker's simulator and its boxes.
"""

import io
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from flask import Flask
from redis import Redis

from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.languages import LANGUAGES
from seamark.server.accounts import accounts
from seamark.server.app import create_app
from seamark.server.runs.ending import account_deletion
from seamark.server.runs.recomputation import verifications
from seamark.server.runs.recomputation.verifications import Outcome, VerificationView
from seamark.server.runs.record.states import RunState
from seamark.server.runs.showing.views import RunView
from seamark.sim import registry
from seamark.worker.evaluation.local import evaluate_locally
from seamark.worker.evaluation.worker_slot import WorkerSlot
from seamark.worker.service.claimed_run import evaluate
from seamark.worker.service.run_driver import RunContext
from seamark.worker.zygote.client import Simulator
from tests.cast import Backend
from tests.journey.short_tracking import BENCHMARK, NAME, PATH, SHARED_NAME, SHARED_PATH
from tests.services import forked_workers

pytestmark = [pytest.mark.host, pytest.mark.slow]
SHORT = {NAME: PATH, SHARED_NAME: SHARED_PATH}
BLIND = b"""
class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        self.corners = corners.copy()

    def update(self, image):
        return self.corners
"""
PLAYBACK = """
import numpy as np

SEEN = np.array({seen})  # (sequences, images, 8) [px]
KNOWN_PX = 20.0  # the target moves by less from the start to the first image


class Tracker:
    def __init__(self, config):
        pass

    def start(self, image, corners):
        distance = np.abs(SEEN[:, 0] - np.ravel(corners)).max(axis=1)
        known = distance.min() < KNOWN_PX
        here = SEEN[distance.argmin()] if known else np.ravel(corners)[np.newaxis]
        self.answers = list(here.reshape(-1, 4, 2))

    def update(self, image):
        return self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]
"""
STARTER = LANGUAGES["python"].starter("tracker")
assert STARTER is not None
CHANGED = """
import os
import time

_update = Tracker.update


def _changed(self, image):
    {before}
    corners = _update(self, image)
    return None if corners is None else corners + 1e-3 * {error}


Tracker.update = _changed
"""
GOOD = STARTER.text().encode()
NAMED = GOOD + CHANGED.format(before="pass", error="len(__file__)").encode()
DICE = GOOD + CHANGED.format(before="pass", error="os.urandom(1)[0]").encode()
SLOW = (
    GOOD + CHANGED.format(before="print('image', flush=True); time.sleep(0.004)", error=0).encode()
)
PROTOCOL = BENCHMARK.protocol
assert PROTOCOL is not None
REFERENCE = PROTOCOL.reference_trials


@dataclass
class Service(Backend):
    """The application, and a worker that runs what is queued."""

    app: Flask
    context: RunContext
    tokens: dict[str, str] = field(default_factory=dict)
    watch: Callable[[], None] = lambda: None  # is called again and again while a run goes on

    def call(self, who: str, method: str, path: str, **options: Any) -> Any:
        if who not in self.tokens:
            scopes = ("read", "submit")
            with self.database.writing() as session:
                token = accounts.new_token(session, self.user_id(who), "t", scopes, days=1)
            self.tokens[who] = token
        headers = {"Authorization": f"Bearer {self.tokens[who]}"}
        return self.app.test_client().open(
            f"/api/v1/runs{path}", method=method, headers=headers, **options
        )

    def ranked(
        self,
        who: str,
        program: bytes | None = None,
        name: str = "mine.py",
        benchmark: str = NAME,
    ) -> RunView:
        """Submit a ranked run of a program, else of the built-in tracker, and evaluate it."""
        self.submit(who, program, name, benchmark)
        view = self.show(self.evaluate_next())
        assert view.cause is None, view.detail
        return view

    def submit(
        self,
        who: str,
        program: bytes | None = None,
        name: str = "mine.py",
        benchmark: str = NAME,
    ) -> int:
        run = {"benchmark": benchmark, "kind": "ranked"}
        if program is None:
            built_in = {"controller": next(iter(BENCHMARK.built_in))}
            answer = self.call(who, "POST", "", json=run | built_in)
        else:
            form = {"run": json.dumps(run), "program": (io.BytesIO(program), name)}
            answer = self.call(who, "POST", "", data=form, content_type="multipart/form-data")
        assert answer.status_code == 202, answer.text
        return int(answer.json["id"])

    def evaluate_next(self) -> int:
        claim = self.claim_next()
        assert evaluate(self.context, claim)
        return claim.run_id

    def verified(self, run_id: int) -> VerificationView:
        """Publish a run, and have it verified."""
        self.publish(run_id)
        with self.database.writing() as session:
            verifications.request(session, run_id, self.settings)
        self.evaluate_next()
        with self.database.reading() as session:
            (found,) = verifications.of_run(session, run_id)
        return found

    def telemetry(self, who: str, run_id: int) -> dict[str, np.ndarray[Any, np.dtype[np.float64]]]:
        answer = self.call(who, "GET", f"/{run_id}/telemetry.f64")
        if answer.status_code == 404:  # nothing yet
            return {"trial": np.empty(0)}
        columns = answer.headers["X-Columns"].split(",")
        return dict(
            zip(columns, np.frombuffer(answer.data).reshape(-1, len(columns)).T, strict=True)
        )


@pytest.fixture(scope="module")
def simulator(
    isolation: IsolationLevel, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Simulator]:
    """A worker's simulator that knows the short benchmark."""
    slot = WorkerSlot(isolation, None)
    mother = forked_workers.mother(slot, SHORT)
    slot = replace(slot, mother=mother.descriptor)
    started = Simulator(slot, tmp_path_factory.mktemp("compiled"))
    started.start()
    yield started
    started.stop()
    mother.stop()


@pytest.fixture
def service(
    backend: Backend,
    isolation: IsolationLevel,
    simulator: Simulator,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Service]:
    for name, path in SHORT.items():
        monkeypatch.setitem(registry.BENCHMARKS, name, path)
    # With a key of its own, each test has other water, and luck decides about the last tenth.
    changes = {"seed_key": "the same water in each test"}
    backend.settings = backend.settings.model_copy(update=changes)
    app = create_app(backend.settings)

    def watched() -> bool:
        found.watch()
        return False

    context = RunContext(
        settings=backend.settings,
        database=backend.database,
        redis=Redis.from_url(backend.settings.broker_url),
        simulator=simulator,
        isolation=isolation,
        shutting_down=watched,
    )
    found = Service(**vars(backend), app=app, context=context)
    yield found
    app.extensions["seamark"].close()


def _digests(run: RunView) -> list[str]:
    assert run.metrics is not None
    return [trial["digest"] for trial in run.metrics["trials"]]


def _recorded(service: Service, who: str, run: RunView) -> bytes:
    """Return a tracker that plays back the corners of a run, as anybody can download them."""
    seen = service.telemetry(who, run.id)
    corners = np.stack([seen[f"corner_{index}"] for index in range(8)], axis=1)
    begins = np.flatnonzero(np.diff(seen["trial"] * 1000 + seen["level"], prepend=-1))
    table = np.array(np.split(corners, begins[1:])).round(2).tolist()
    return PLAYBACK.format(seen=table).encode()


def test_a_program_that_plays_back_what_it_saw_gains_nothing(service: Service) -> None:
    honest = service.ranked("ann")
    service.publish(honest.id)
    blind = service.ranked("ben", BLIND)
    playback = service.ranked("eva", _recorded(service, "eva", honest))

    assert honest.metrics is not None
    assert blind.metrics is not None
    assert playback.metrics is not None
    assert honest.score is not None
    assert blind.score is not None
    assert playback.metrics["reference"]["score"] >= honest.metrics["reference"]["score"] > 0.9
    assert playback.score == pytest.approx(blind.score, abs=1e-9)
    assert blind.score < 0.2 * honest.score
    gap = playback.metrics["gap"]
    assert gap["low"] > 0.5
    assert honest.metrics["gap"]["low"] <= 0.0 <= honest.metrics["gap"]["high"]


def test_a_program_that_knows_its_published_water_alone_is_not_confirmed_in_fresh_water(
    service: Service,
) -> None:
    honest = service.ranked("ann", benchmark=SHARED_NAME)
    playback = service.ranked("eva", _recorded(service, "ann", honest), benchmark=SHARED_NAME)
    assert playback.score is not None
    assert honest.score is not None

    found = [service.verified(run.id) for run in (honest, playback)]

    assert playback.score > 0.9 * honest.score > 0.0
    assert [each.outcome for each in found] == [Outcome.AGREES, Outcome.DIFFERS]
    assert (found[1].score or 0.0) < 0.2 * playback.score


def test_anybody_can_repeat_the_reference_trials(service: Service) -> None:
    ranked = service.ranked("ann")

    here = evaluate_locally(
        NAME, {}, seed=2026, trials=REFERENCE, controller=next(iter(BENCHMARK.built_in))
    )

    assert here.metrics is not None
    assert [trial["digest"] for trial in here.metrics["trials"]] == _digests(ranked)[:REFERENCE]


def test_the_same_submission_has_the_same_result_and_a_changed_byte_other_fresh_water(
    service: Service,
) -> None:
    first = service.ranked("ann", BLIND)
    again = service.ranked("ben", BLIND, name="renamed.py")
    changed = service.ranked("ann", BLIND + b"\n")

    assert (again.digest, again.score) == (first.digest, first.score)
    assert first.manifest is not None
    assert changed.manifest is not None
    assert not set(first.manifest["seeds"][REFERENCE:]) & set(changed.manifest["seeds"][REFERENCE:])
    assert _digests(first)[:REFERENCE] == _digests(changed)[:REFERENCE]
    assert not set(_digests(first)[REFERENCE:]) & set(_digests(changed)[REFERENCE:])


def _trials(service: Service, who: str, run_id: int) -> list[int]:
    return sorted({int(trial) for trial in service.telemetry(who, run_id)["trial"]})


def test_nobody_sees_the_fresh_trials_of_a_run_before_its_end(service: Service) -> None:
    run_id = service.submit("ann", SLOW)
    seen: list[tuple[float, list[int], str]] = []

    def watch() -> None:
        run = service.call("ann", "GET", f"/{run_id}").json
        log = service.call("ann", "GET", f"/{run_id}/log.txt")
        text = log.text if log.status_code == 200 else ""
        seen.append((run["t_simulated"], _trials(service, "ann", run_id), text))

    service.watch = watch
    service.evaluate_next()
    service.watch = lambda: None

    reference = list(range(REFERENCE))
    ended = service.show(run_id)
    log = service.call("ann", "GET", f"/{run_id}/log.txt").text
    assert ended.state == RunState.SUCCEEDED
    assert _trials(service, "ann", run_id) == list(range(ended.trials))
    images = max(text.count("image") for _, _, text in seen)
    assert any(trials == reference for _, trials, _ in seen)  # these are seen as they are recorded
    assert all(set(trials) <= set(reference) for _, trials, _ in seen)
    assert images * ended.trials == log.count("image") * REFERENCE


def test_who_cancels_a_run_sees_no_fresh_trial_and_uses_nothing_up_for_others(
    service: Service,
) -> None:
    run_id = service.submit("ann", SLOW)
    reference_rows = BENCHMARK.read({}).telemetry_shape()[0] * REFERENCE

    def cancel_in_fresh_water() -> None:
        if len(service.telemetry("ann", run_id)["trial"]) == reference_rows:
            service.cancel(run_id)

    service.watch = cancel_in_fresh_water
    service.evaluate_next()
    service.watch = lambda: None
    honest, again = (service.ranked(who, SLOW) for who in ("ben", "ann"))

    assert service.show(run_id).state == RunState.CANCELLED
    assert _trials(service, "ann", run_id) == list(range(REFERENCE))
    assert honest.rankable is True
    assert again.digest == honest.digest


def test_a_program_cannot_be_told_anything_by_the_name_of_its_file(service: Service) -> None:
    first = service.ranked("ann", NAMED, name="a.py")
    again = service.ranked("ben", NAMED, name="a-much-longer-name.py")

    assert (again.digest, again.rankable) == (first.digest, True)


def test_an_account_that_is_deleted_does_not_take_away_what_it_has_seen(service: Service) -> None:
    service.ranked("ann", DICE)
    with service.database.writing() as session:
        account_deletion.close(session, service.user_id("ann"), keep_published=False)
    while account_deletion.step(service.database, service.settings):
        pass

    later = service.ranked("ben", DICE)

    assert later.rankable is False
    assert (later.not_ranked or "").startswith("A run of another account was of the same program")

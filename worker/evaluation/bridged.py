"""Trials whose program is connected by rosbridge: on the server, where it has a slot meanwhile.

The other end of the socket is a process of the worker, which passes on what the program's author
sends. Here it is parsed, where there is no secret, no database and no broker.
"""

import json
import time
from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seamark.bridge.rosbridge.lock_step import LockStep, Rules
from seamark.bridge.rosbridge.program import RosProgram, opened
from seamark.sim import registry
from seamark.sim.engine.program import Command
from seamark.sim.engine.world import target_and_optics
from seamark.sim.settings.experiment import ExperimentSettings
from seamark.worker.evaluation.evaluation import Evaluation
from seamark.worker.evaluation.job import Job
from seamark.worker.evaluation.program_adapters import MakeBox
from seamark.worker.ipc.listener import Listener
from seamark.worker.ipc.outcomes import RunOutcome

# A program that is far away and slow still takes part; one that hangs gives its slot to others.
ANSWER_S = 10.0
FIRST_ANSWER_S = 60.0
WHOLE_S = 900.0
_SENTENCES_MAX = 100  # that wait for the next control step
_SIGN_OF_LIFE_S = 5.0  # rows of a slow program come seldom, and a silent simulation counts as hung


def evaluate_bridged(job: Job, listener: Listener, make_box: MakeBox) -> RunOutcome:
    """Evaluate the program that connects at `job.bridge`; tell it how its run has ended.

    Raises
    ------
    ConfigurationInvalid
        The configuration is wrong, or of a benchmark without a vehicle.
    """
    assert job.bridge is not None  # noqa: S101 - the caller asked
    config = registry.benchmark(job.benchmark).restore(job.config)
    assert isinstance(config, ExperimentSettings)  # noqa: S101 - submission.py refuses others
    _target, optics = target_and_optics(config)
    rules = Rules(
        answer_s=ANSWER_S, first_answer_s=FIRST_ANSWER_S, whole_s=WHOLE_S, one_client=True
    )
    sentences = deque[str](maxlen=_SENTENCES_MAX)
    logging = _SentenceLog(listener, sentences)
    arm = config.chosen_arm()
    lock_step = LockStep(rules, joints=len(arm.motors()) if arm else 0)
    with opened(lock_step, job.bridge, say=sentences.append) as bridge:
        program = _Attended(logging, bridge, optics, arm)
        outcome = Evaluation(job, logging, make_box, connected=program).run()
        logging.log_sentences()
        bridge.publish_result(result_message(outcome))
    return outcome


def result_message(outcome: RunOutcome) -> str:
    """Return how a run ended, for its program: JSON."""
    metrics = outcome.metrics or {}
    verdict = str(outcome.failure or "ok")
    values = {"verdict": verdict, "sentence": outcome.sentence, "score": metrics.get("score")}
    return json.dumps(values | {"digest": outcome.digest}, allow_nan=False)


class _SentenceLog:
    """Forwards everything; what the bridge has to say goes into the log of the program.

    It is said in the thread of the bridge, and sent in that of the trials, as all else is.
    """

    def __init__(self, listener: Listener, sentences: deque[str]) -> None:
        self._listener, self._sentences = listener, sentences
        self._sent_at = time.monotonic()

    def log_sentences(self) -> None:
        while self._sentences:
            self.log(f"[{self._sentences.popleft()}]\n".encode())

    def show_life(self) -> None:
        self.log_sentences()
        if time.monotonic() > self._sent_at + _SIGN_OF_LIFE_S:
            self.log(b"")

    def rows(self, rows: NDArray[np.float64]) -> None:
        self._sent_at = time.monotonic()
        self._listener.rows(rows)

    def log(self, text: bytes) -> None:
        self._sent_at = time.monotonic()
        self._listener.log(text)

    def trial_ended(self, trial: int) -> None:
        self._listener.trial_ended(trial)

    def trial_restarted(self, trial: int, reason: str) -> None:
        self._listener.trial_restarted(trial, reason)


class _Attended(RosProgram):
    """A program whose steps show that the simulation goes on."""

    def __init__(self, log: _SentenceLog, *bridged: Any) -> None:
        super().__init__(*bridged)
        self._log = log

    def step(self, values: NDArray[np.float64]) -> Command:
        command = super().step(values)
        self._log.show_life()
        return command

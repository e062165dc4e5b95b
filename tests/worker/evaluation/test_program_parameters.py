"""Parameters of a program reach its `config`, in each language, and the manifest."""

import json
from typing import Any

import pytest

from seamark.programs.preparation import prepare
from seamark.worker.evaluation.local import Callbacks, evaluate_locally
from seamark.worker.ipc.outcomes import RunOutcome

pytestmark = pytest.mark.host

SHORT = {"levels": [0.1], "level_duration_s": 2.0, "settle_s": 1.0, "tracker": "truth"}
PYTHON = b"""
PARAMETERS = {"gain": 0.25, "order": 2, "kp": 1.0}

class Controller:
    def __init__(self, config):
        print(config["gain"], config["order"], config["kp"])

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]
"""
C = b"""
#include <stdio.h>
#include "seamark.h"
// @parameter gain 0.25
// @parameter order 2
// @parameter kp 1.0

int seamark_init(void) {
    printf("%g %g %g\\n", seamark_config_number("gain", 0), seamark_config_number("order", 0),
           seamark_config_number("kp", 0));
    return 0;
}

int seamark_step(const seamark_observation *observation, seamark_command *command) { return 0; }
"""
MATLAB = b"""
% @parameter gain 0.25
% @parameter order 2
% @parameter kp 1.0
function state = controller_setup(config)
    printf("%g %g %g\\n", config.gain, config.order, config.kp);
    state = 0;
end
function command = controller_step(state, observation)
    command = [0 0 0 0];
end
"""


def _outcome(source: bytes, name: str, isolation: Any, printed: list[bytes]) -> RunOutcome:
    given = {"gain": 1.5, "order": 4, "kp": 0.125}
    return evaluate_locally(
        "currents-v1",
        SHORT | {"parameters": given},
        seed=5,
        controller=prepare(source, name),
        isolation=isolation,
        callbacks=Callbacks(log=printed.append),
    )


@pytest.mark.parametrize(
    ("source", "name"), [(PYTHON, "mine.py"), (C, "mine.c"), (MATLAB, "mine.m")]
)
def test_a_program_finds_its_parameters_in_its_configuration(
    source: bytes, name: str, isolation: Any
) -> None:
    printed: list[bytes] = []

    outcome = _outcome(source, name, isolation, printed)

    assert outcome.failure is None, outcome.sentence
    assert b"".join(printed).split() == [b"1.5", b"4", b"0.125"]
    manifest = json.loads(json.dumps(outcome.manifest))
    assert manifest["parameters"] == {"gain": 1.5, "order": 4, "kp": 0.125}
    assert manifest["configuration"]["kp"] == 0.5

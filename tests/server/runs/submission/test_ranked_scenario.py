"""A ranked run is what is in effect: nothing else may change its water."""

import pytest
from sqlalchemy import update

from seamark.server.database.tables import Run
from seamark.server.runs.record.states import RunKind
from seamark.sim.settings.refusal import ConfigurationInvalid
from tests.cast import Backend

RANKED = {"kind": RunKind.RANKED, "benchmark": "currents-v2"}
TRACKER = """
class Tracker:
    def __init__(self, config): ...
    def start(self, image, corners): ...
    def update(self, image): ...
"""


@pytest.mark.parametrize(
    ("controller", "setting", "value"),
    [("pi", "visp_iterations", 50), ("lqr", "kp", 0.9), ("p", "ki", 0.3), ("pi", "pid_kp", 1.0)],
)
def test_a_ranked_run_refuses_a_setting_without_effect(
    backend: Backend, controller: str, setting: str, value: float
) -> None:
    with pytest.raises(ConfigurationInvalid, match="has no effect") as refusal:
        backend.queue("ann", controller=controller, config={setting: value}, **RANKED)

    assert set(refusal.value.errors) == {setting}


def test_a_setting_in_effect_decides_the_water(backend: Backend) -> None:
    one, other = (backend.queue("ann", config={"kp": kp}, **RANKED) for kp in (0.5, 0.6))

    assert backend.show(one).submission != backend.show(other).submission


def test_a_setting_without_effect_may_be_sent_as_it_is(backend: Backend) -> None:
    plain = backend.queue("ann", controller="lqr", **RANKED)
    whole = backend.queue("ann", controller="lqr", config=backend.show(plain).config, **RANKED)

    assert backend.show(whole).submission == backend.show(plain).submission


def test_the_options_of_the_built_in_tracker_have_no_effect_on_an_own_one(backend: Backend) -> None:
    program = backend.store_program(TRACKER.encode(), role="tracker")
    wanted = {"kind": RunKind.RANKED, "benchmark": "visibility-v2", "controller": "upload"}

    backend.queue("ann", program=program, config={}, **wanted)
    with pytest.raises(ConfigurationInvalid, match="has no effect"):
        backend.queue("ann", program=program, config={"warp": "srt"}, **wanted)


def test_a_run_of_an_earlier_version_with_a_setting_without_effect_can_be_run_again(
    both: Backend,
) -> None:
    old = both.queue("ann", controller="lqr", **RANKED)
    with both.database.writing() as session:
        config = both.show(old).config | {"kp": 0.9}
        session.execute(update(Run).where(Run.id == old).values(config=config))

    again = both.rerun(old)

    assert both.show(again).config["kp"] == 0.5


def test_a_practice_run_keeps_settings_without_effect(backend: Backend) -> None:
    run_id = backend.queue("ann", benchmark="currents-v2", controller="lqr", config={"kp": 0.9})

    assert backend.show(run_id).config["kp"] == 0.9

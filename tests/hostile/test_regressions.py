"""How other sandboxes were broken: a test for each, named after the vulnerability."""

import os

import pytest

from seamark.sandbox.box import Box
from seamark.sandbox.isolation import proc_stats
from seamark.sandbox.isolation.level import IsolationLevel
from seamark.sandbox.outcome import Verdict
from tests.hostile.conftest import LAYOUT, LONG_WAITS
from tests.hostile.corpus import case

pytestmark = pytest.mark.host


def held(outcome) -> bool:
    return (
        outcome.verdict is Verdict.OK
        and b"held" in outcome.output
        and b"GOT" not in (outcome.output)
    )


def test_judge0_cve_2024_28185_no_link_leads_the_trusted_side_out_of_the_box(run) -> None:
    assert held(run("regression_judge0_cve_2024_28185"))


def test_judge0_cve_2024_28189_no_file_changes_hands_by_a_link(run) -> None:
    outcome = run("regression_judge0_cve_2024_28189")

    assert held(outcome)
    assert outcome.output.count(b"held") == 7


def test_judge0_cve_2024_29021_no_service_of_the_platform_can_be_reached(run) -> None:
    assert held(run("regression_judge0_cve_2024_29021"))


def test_isolate_shared_dev_shm_two_boxes_at_once_see_nothing_of_each_other(
    isolation: IsolationLevel,
) -> None:
    source = case("regression_isolate_shared_dev_shm").source

    with (
        Box(limits=LONG_WAITS, isolation=isolation) as one,
        Box(limits=LONG_WAITS, isolation=isolation) as other,
    ):
        for box in (one, other):
            box.load(source, "a.py", {}, LAYOUT)
        outputs = [box.finish().output for box in (one, other)]

    assert outputs[0].count(b"held") == 2  # it left something in the two others
    assert outputs[1] == outputs[0]
    assert b"GOT" not in outputs[0]


def test_bubblewrap_as_root_keeping_uid_0_a_program_is_nobody_on_the_host(run, isolation) -> None:
    assert held(run("regression_bubblewrap_root_keeps_uid_0"))

    with Box(limits=LONG_WAITS, isolation=isolation) as box:
        box.wait_ready()
        uids = {proc_stats.uid_of(pid) for pid in box.processes()}
    assert 0 not in uids or os.geteuid() != 0


def test_proc_1_environ_holds_nothing_of_the_worker(run, secret) -> None:
    outcome = run("secrets_proc_1_environ")

    assert held(outcome)
    assert secret.encode() not in outcome.output


def test_af_vsock_does_not_lead_to_the_hypervisor(run) -> None:
    assert held(run("network_vsock"))

"""Short sessions of faults on a whole service; `./run chaos` is the long one."""

import pytest

from tests.chaos.campaign import Campaign
from tests.chaos.faults import FAULTS
from tests.chaos.installation import installation

SEED = 1
SHORT_LEASES = {"lease_s": 3.0, "warm_boxes": 0}
QUICK = (
    "pool child killed",
    "simulator killed",
    "broker killed",
    "database restarted",
    "tickets confused",
    "clock jumps",
    "disk full",
    "storage away",
)


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize(
    ("copies", "runs"),
    [
        # Most of the CPU time goes into starting workers and web servers.
        (1, 8),
        pytest.param(2, 12, marks=pytest.mark.long),
    ],
)
def test_whatever_happens_to_a_service_each_run_gets_the_result_of_an_undisturbed_one(
    copies: int, runs: int
) -> None:
    with installation(copies=copies, **SHORT_LEASES) as service:
        found = Campaign(service, runs, SEED).run(*(FAULTS[name] for name in QUICK))

        assert found.problems == [], service.releases()

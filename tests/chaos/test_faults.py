"""Short sessions of faults on a whole service; `./run chaos` is the long one."""

import pytest

from tests.chaos.campaign import Campaign
from tests.chaos.faults import FAULTS
from tests.chaos.installation import installation

SEED = 1
PAUSE_MAX_S = 0.3  # or all runs would have ended before most of the faults
SHORT_LEASES = {"lease_s": 3.0, "warm_boxes": 0}
# What needs a service and is over within seconds.
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
# Without those that short tests inject into a worker's run: test_killed_parts.py kills the pool's
# child; test_full_disk.py fills the disk and takes the data folder away.
SHORT = tuple(
    name for name in QUICK if name not in ("pool child killed", "disk full", "storage away")
)


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize(
    ("faults", "copies", "runs", "forked"),
    [
        (SHORT, 1, 16, True),
        pytest.param(QUICK, 1, 24, False, marks=pytest.mark.long),
        pytest.param(QUICK, 2, 32, False, marks=pytest.mark.long),
    ],
)
def test_whatever_happens_to_a_service_each_run_gets_the_result_of_an_undisturbed_one(
    faults: tuple[str, ...], copies: int, runs: int, *, forked: bool
) -> None:
    with installation(copies=copies, forked=forked, **SHORT_LEASES) as service:
        campaign = Campaign(service, runs, SEED, pause_max_s=PAUSE_MAX_S)
        found = campaign.run(*(FAULTS[name] for name in faults))

        assert found.too_late == 0
        assert found.problems == [], service.releases()

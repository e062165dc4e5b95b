"""Short sessions of faults on a whole service; `./run chaos` is the long one."""

import pytest

from tests.chaos.campaign import Campaign
from tests.chaos.faults import FAULTS
from tests.chaos.installation import installation

SEED = 1
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
# Those of them that no other short test has: see test_killed_parts.py, test_lease_watch.py,
# test_full_disk.py and test_storage_blips.py.
ONLY_HERE = ("broker killed", "database restarted", "tickets confused")


@pytest.mark.slow
@pytest.mark.host
@pytest.mark.parametrize(
    ("faults", "copies", "runs"),
    [
        (ONLY_HERE, 1, 4),
        pytest.param(QUICK, 1, 8, marks=pytest.mark.long),
        pytest.param(QUICK, 2, 12, marks=pytest.mark.long),
    ],
)
def test_whatever_happens_to_a_service_each_run_gets_the_result_of_an_undisturbed_one(
    faults: tuple[str, ...], copies: int, runs: int
) -> None:
    with installation(copies=copies, **SHORT_LEASES) as service:
        found = Campaign(service, runs, SEED).run(*(FAULTS[name] for name in faults))

        assert found.problems == [], service.releases()

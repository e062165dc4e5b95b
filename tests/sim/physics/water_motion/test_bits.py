"""Water that moves by a table has the same bits in two processes and on the oldest processor."""

import pytest

from tests.services.prepared import printed
from tests.sim.oldest_processor import printed_here

PROGRAM = """
import hashlib
import numpy as np
from seamark.sim.numerics.random_streams import streams
from seamark.sim.physics.plant import Plant
from seamark.sim.physics.water_motion.places import PLACES
from seamark.sim.physics.water_motion.record import read_record
from seamark.sim.physics.water_motion.tabulation import Motion, Site, current_of
from seamark.sim.physics.water_motion.waves import Waves
from seamark.sim.vehicles import load

times = [(i, height) for i in range(30) for height in (1, 3)]
rows = [f"{60 * i},{h},{0.1 * h + 0.01 * i},{0.05 * h},{0.001 * i}" for i, h in times]
head = ["# seamark-current 1", "time_s,height_m,north,east,down"]
record = read_record("\\n".join(head + rows).encode())
site = Site(bottom_m=5.0, start_m=2.7, azimuth_rad=0.7, duration_s=20.0)
digest = hashlib.sha256()
for place in (None, *PLACES.values()):
    for waves in (None, Waves(0.6, 4.0)):
        motion = Motion(place=place, record=record, waves=waves)
        plant = Plant(load("girona500"), current_of(0.3, motion, site, streams(3, 1, 2)))
        plant.reset(np.array([0.0, 0.0, 2.7, 0.1, 0.1, 0.3]))
        for step in range(0, 2000, 100):
            plant.advance(step, 0.2 * np.ones(5), 100)
            digest.update(plant.state.tobytes() + plant.acceleration().tobytes())
        digest.update(plant.water.drift.tobytes())
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_tables_and_what_moves_in_them_have_the_same_bits_everywhere() -> None:
    assert printed_here(PROGRAM) == printed(PROGRAM, on="oldest")

"""Compile before the tests, on all cores, what tests alone need compiled.

    python -m tests.precompile

`warm_up` of the simulator compiles what runs need. The rest is here: vehicles that move side by
side, what tests call one by one, and what is compared with the oldest processor. Numba's cache has
no lock, so several processes of tests would all compile the same functions. Those that are missing
here are listed at the end of the tests (`tests/services/late_compilation.py`).

The modules of the tests are compiled as well: pytest rewrites their assertions, and Hypothesis
looks for the constants of our code. That takes longer than to load them.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

from tests.sim.benchmarks.dock_v1 import test_bits as dock_bits
from tests.sim.benchmarks.track_v1 import test_bits as track_bits
from tests.sim.camera import test_link_camera
from tests.sim.camera.bottom import test_bottom
from tests.sim.control import test_pixels
from tests.sim.control.mpc import test_horizon
from tests.sim.detectors import test_detectors, test_faces
from tests.sim.detectors.network import test_network
from tests.sim.engine import test_arm_bits
from tests.sim.multibody import test_bits
from tests.sim.oldest_processor import OLDEST_PROCESSOR
from tests.sim.physics import test_integration
from tests.sim.physics.water_motion import test_bits as water_bits
from tests.sim.sonar import test_images as sonar_images
from tests.sim.trackers import test_upright_boxes
from tests.sim.trackers.template import test_template

SIMULATOR = Path(__file__).parent / "sim"
ENVIRONMENTS = """
from seamark.gym.vector import StationKeepingVectorEnv

truth = {"tracker": "truth"}
for options in (
    {"benchmark": "currents-v2", "settings": truth},
    {"benchmark": "currents-v1", "settings": truth},
    {"benchmark": "currents-v2", "settings": truth, "action": "thrusters"},
    {"benchmark": "currents-v2"},
    {"benchmark": "currents-v2", "observation": "image"},
    {"benchmark": "currents-v2", "observation": "image+depth"},
    {"benchmark": "currents-v2", "settings": truth, "observation": "image"},
    {"benchmark": "currents-v2", "settings": truth, "observation": "image+depth"},
    {"benchmark": "currents-v2", "settings": truth, "observation": "depth"},
):
    env = StationKeepingVectorEnv(num_envs=2, **options)
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.close()
"""

MECHANISMS = """
import numpy as np
from seamark.sim.fleet.mechanisms import Mechanisms
from seamark.sim.multibody.mechanism import state_for
from tests.sim.fleet.test_mechanisms import GROUND, STEP_S, TIMING, current, vehicle_with_arm

model = vehicle_with_arm().model(STEP_S)
fleet = Mechanisms([model], [current(0)], GROUND, TIMING)
fleet.place(0, state_for(model), step=0)
fleet.advance(1, np.zeros((1, 8)), np.zeros((1, 5)))
fleet.close()
"""

IDENTIFICATION = """
from performance.statistics.identification.coverage import held

held(1000, seconds=12.0)
"""

CALLED_ALONE = (  # tests of functions that runs do not call by themselves
    "camera/test_link_camera.py::test_points_are_shown_unless_something_is_before_them",
    "camera/test_seabed.py",
    "camera/test_pictures.py::test_painted_pictures_are_the_same_bytes_everywhere",
    "control/test_allocation.py::test_it_finds_the_bounded_least_squares_solution_of_scipy",
    "control/test_pixels.py::test_the_eye_finds_nothing_in_an_image_of_one_grey",
    "control/test_reference_controllers.py::test_the_oracle_holds_station_within_a_centimetre",
    "multibody/test_loads.py::test_loads_of_the_outer_links_alone_are_those_among_all",
    "multibody/test_loads.py::test_the_bottom_carries_the_weight_of_what_lies_on_it",
    "multibody/test_dynamics.py::test_a_vehicle_without_an_arm_accelerates_as_the_plant",
    "physics/test_contact.py::test_a_steady_force_of_fifty_newtons_reads_fifty_newtons",
    "engine/test_delay.py",
    "engine/test_perception.py",
    "detectors/test_detectors.py::test_the_stored_looks_are_those_that_the_painter_paints",
    "detectors/test_faces.py::test_letters_that_cannot_be_told_apart_are_no_evidence",
    "numerics/test_fourier.py",
    "numerics/test_libm.py::test_angles_of_the_four_quadrants_have_their_signs",
    "physics/test_hydrodynamics.py",
    "physics/water_motion/test_tabulation.py",
    "trackers/template/test_normal_equations.py",
    "trackers/template/test_template.py::test_homography_is_within_a_tenth_of_a_pixel[esm-mi]",
)


def main() -> None:
    """Compile all parts, as many at a time as there are cores."""
    with tempfile.TemporaryDirectory() as folder:
        images = test_template.draw(Path(folder))
        parts = (
            _collect,
            partial(_run, ENVIRONMENTS, {}),
            partial(_run, test_link_camera.PROGRAM, {}),
            partial(_run, test_detectors.PROGRAM, {}, *test_detectors.EVERY),
            partial(_run, MECHANISMS, {}),
            partial(_run, IDENTIFICATION, {}),
            _call_alone,
            partial(_run, test_template.PROGRAM, OLDEST_PROCESSOR, str(images)),
            partial(_run, test_bits.SCENES, OLDEST_PROCESSOR),
            partial(_run, test_link_camera.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, test_bottom.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, sonar_images.PROGRAM, {}),
            partial(_run, sonar_images.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, test_detectors.PROGRAM, OLDEST_PROCESSOR, *test_detectors.QUICK),
            partial(_run, test_faces.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, test_network.BITS_OF_PARTS, OLDEST_PROCESSOR),
            partial(_run, test_pixels.BITS, {}),
            partial(_run, test_pixels.BITS, OLDEST_PROCESSOR),
            partial(_run, test_horizon.BITS, OLDEST_PROCESSOR),
            partial(_run, test_upright_boxes.BITS, OLDEST_PROCESSOR),
            partial(_run, test_integration.RUN, OLDEST_PROCESSOR),
            partial(_run, test_arm_bits.PROGRAM, OLDEST_PROCESSOR, *test_arm_bits.RECOVER),
            partial(_run, track_bits.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, water_bits.PROGRAM, {}),
            partial(_run, water_bits.PROGRAM, OLDEST_PROCESSOR),
            partial(_run, dock_bits.PROGRAM, OLDEST_PROCESSOR, *dock_bits.CONTROLLERS[:1]),
        )
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            for done in [pool.submit(part) for part in parts]:
                done.result()


def _run(program: str, variables: Mapping[str, str], *arguments: str) -> None:
    command = [sys.executable, "-c", program, *arguments]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | variables)


def _collect() -> None:
    _pytest("--collect-only")


def _call_alone() -> None:
    tests = [str(SIMULATOR / test) for test in CALLED_ALONE]
    _pytest("--confcutdir", str(SIMULATOR), *tests)  # no server


def _pytest(*arguments: str) -> None:
    # What fails here fails again among the tests, which show it.
    command = [sys.executable, "-m", "pytest", "--quiet", "-p", "no:cacheprovider", *arguments]
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()

"""The simulator: vehicle, water, camera, trackers, controllers, benchmarks. Runs alone."""

import importlib.metadata
import os

from seamark.sim.numerics.numba_internals import configure_cache

configure_cache(os.environ, importlib.metadata.version("numba"))

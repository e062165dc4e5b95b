"""The simulator: vehicle, water, camera, trackers, controllers, benchmarks. Runs alone."""

import os

# Before Numba is imported, which reads the variable once. The two others are Numba's own, for code
# that is not ours; see sim/numerics/compiled_cache.py for why its own will not do for us.
os.environ.setdefault(
    "NUMBA_CACHE_LOCATOR_CLASSES",
    "seamark.sim.numerics.compiled_cache.NamedAfterSources,InTreeCacheLocator,UserWideCacheLocator",
)

"""The simulator: vehicle, water, camera, trackers, controllers, benchmarks. Runs alone."""

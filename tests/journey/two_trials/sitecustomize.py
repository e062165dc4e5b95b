"""Which currents-v1 the processes of a service have that find this folder on their PYTHONPATH."""

from seamark.sim import registry

registry.BENCHMARKS["currents-v1"] = "two_trials:BENCHMARK"

"""currents-v1 with ranked runs of two trials, a fifth of the real ones: 120,000 steps take 10 s."""

from dataclasses import replace

from seamark.sim.benchmarks.currents_v1.definition import BENCHMARK as TEN_TRIALS

TRIALS = 2
BENCHMARK = replace(TEN_TRIALS, shared_trials=TRIALS)

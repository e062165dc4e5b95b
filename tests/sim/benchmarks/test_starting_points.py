"""The presets of the form."""

import pytest

from seamark.sim import registry

POINTS = [
    (benchmark, name)
    for benchmark in registry.BENCHMARKS
    for name in registry.benchmark(benchmark).starting_points
]


@pytest.mark.parametrize(("name", "point"), POINTS)
def test_a_preset_is_a_valid_configuration_with_a_solution_that_users_may_choose(
    name: str, point: str
) -> None:
    benchmark = registry.benchmark(name)
    chosen = benchmark.starting_points[point]

    config = benchmark.read(chosen.config)

    assert {setting: getattr(config, setting) for setting in chosen.config} == dict(chosen.config)
    assert chosen.built_in in ("", *benchmark.built_in)


def test_every_benchmark_has_presets() -> None:
    assert {benchmark for benchmark, _ in POINTS} == set(registry.BENCHMARKS)

"""Further programs of a run: each has a role of its own beside what the benchmark evaluates."""

from seamark.sandbox.languages.language import ALL_ROLES, CONTROLLER
from seamark.sim.benchmarks.benchmark import Benchmark

ROLES = tuple(role for role in ALL_ROLES if role != CONTROLLER)  # that any benchmark may have


def field(role: str) -> str:
    """Return the name of the file of a part in forms: a setting already has that of the role."""
    return f"{role}_program"


def refusal(benchmark: Benchmark, role: str) -> str:
    """Return why a run cannot have a program of a role as a part; empty if it can."""
    if role in benchmark.parts:
        return ""
    other = f"it may have a {' and a '.join(benchmark.parts)}" if benchmark.parts else "it has none"
    return f"{benchmark.name} takes no program as its {role}: {other}."

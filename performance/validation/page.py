"""The page: all sections, one after the other."""

from pathlib import Path
from types import ModuleType

from performance.validation import (
    analytic,
    convergence,
    determinism,
    facts,
    girona,
    independent,
    vehicles,
)
from sim.manifest import code_sha256, versions

SECTIONS: tuple[ModuleType, ...] = (
    facts,
    girona,
    analytic,
    convergence,
    independent,
    determinism,
    vehicles,
)
SHOWN_VERSIONS = ("python", "numpy", "numba", "opencv-python-headless")


def titles() -> list[str]:
    """Return the headings of the page."""
    return [section.TITLE for section in SECTIONS]


def introduction() -> str:
    """Return what stands above the sections."""
    used = ", ".join(f"{name} {versions()[name]}" for name in SHOWN_VERSIONS)
    return "\n\n".join(
        [
            "# Validation",
            "This page is written by `./run validation`; every number of ours comes from that "
            "computation. Published numbers are those of Pérez, Sales, Marín and Sanz, *Online "
            "Tool for Benchmarking of Simulated Intervention Autonomous Underwater Vehicles*.",
            f"Computed with the simulator's sources `{code_sha256()[:16]}` (SHA-256 over `sim/`, "
            f"as in a run's manifest), {used}.",
        ]
    )


def write(out: Path) -> None:
    """Compute everything and write the page to `out`, its plots to `figures` beside it."""
    names = vehicles.names()
    parts = [introduction()]
    for number, section in enumerate(SECTIONS, start=1):
        print(f"{number}/{len(SECTIONS)} {section.TITLE}", flush=True)
        parts.append(f"## {section.TITLE}")
        parts.append(section.section(names, out.parent / "figures"))
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n\n".join(parts) + "\n", encoding="utf-8")

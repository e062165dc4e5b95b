"""The page with all its sections."""

from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
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
from seamark.sim.recording.manifest import code_sha256, versions

SECTIONS: tuple[ModuleType, ...] = (
    facts,
    girona,
    analytic,
    convergence,
    independent,
    determinism,
    vehicles,
)
SHOWN_VERSIONS = ("python", "numpy", "numba", "opencv-contrib-python-headless")


def titles() -> list[str]:
    """Return the headings of the page."""
    return [section.TITLE for section in SECTIONS]


def introduction() -> str:
    """Return the text above the sections."""
    used = ", ".join(f"{name} {versions()[name]}" for name in SHOWN_VERSIONS)
    return "\n\n".join(
        [
            "# Validation",
            "This page is written by `./run validation`, which computes every number of ours. "
            "The published numbers are those of Pérez, Sales, Marín and Sanz, *Online "
            "Tool for Benchmarking of Simulated Intervention Autonomous Underwater Vehicles*.",
            f"Computed with simulator sources `{code_sha256()[:16]}` (SHA-256 over `sim/`, as in "
            f"the manifest of a run), {used}.",
        ]
    )


def section_text(title: str, names: list[str], figures: Path) -> str:
    """Compute one section, write its plots and return its text."""
    (section,) = (section for section in SECTIONS if title == section.TITLE)
    text: str = section.section(names, figures)
    return text


def write(out: Path) -> None:
    """Compute everything and write the page to `out`, its plots to `figures` beside it.

    Two sections run at a time, the slowest first, each in a process of its own.
    """
    names, texts = vehicles.names(), {}
    context = get_context("spawn")  # the threads of Numba and OpenCV do not survive a fork
    with ProcessPoolExecutor(max_workers=2, mp_context=context) as pool:
        pending = {
            pool.submit(section_text, title, names, out.parent / "figures"): title
            for title in sorted(titles(), key=lambda title: title != determinism.TITLE)
        }
        for done in as_completed(pending):
            texts[pending[done]] = done.result()
            print(f"{len(texts)}/{len(pending)} {pending[done]}", flush=True)
    parts = [introduction(), *(f"## {title}\n\n{texts[title]}" for title in titles())]
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text("\n\n".join(parts) + "\n", encoding="utf-8")

"""Compute docs/validation.md and its plots: `./run performance validation [--out FILE]`."""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

from performance import DOCS
from performance.simulator.validation import (
    analytic,
    blind,
    convergence,
    determinism,
    drag_tests,
    facts,
    girona,
    independent,
    links,
    summary,
    thrust_tests,
    touch,
    touch_steps,
    vehicles,
    water_tests,
)
from performance.simulator.validation.floating_arm import section as floating_arm
from seamark.sim.recording.manifest import code_sha256, versions


class Part(NamedTuple):
    """A part of the page: its heading, what it shows, and its sections."""

    title: str
    text: str
    sections: tuple[ModuleType, ...]


PARTS = (
    Part(
        "Validation",
        "This part compares published measurements of real vehicles and real water with the "
        "simulator's prediction for the same set-up. Errors are our value relative to the "
        "measurement.",
        (summary, thrust_tests, drag_tests, floating_arm, water_tests),
    ),
    Part(
        "Verification",
        "Does the code solve its equations, and does it do what the original simulator did? "
        "This part checks closed forms, an independent implementation, convergence, determinism "
        "and the published experiment, which was a simulation too, and whether the benchmarks "
        "measure what they should. Agreement here says nothing about real water.",
        (
            analytic,
            convergence,
            independent,
            links,
            touch,
            touch_steps,
            determinism,
            facts,
            girona,
            blind,
        ),
    ),
    Part(
        "Parameters",
        "These are all numbers of all vehicles, with their sources.",
        (vehicles,),
    ),
)
SECTIONS = tuple(section for part in PARTS for section in part.sections)
SHOWN_VERSIONS = ("python", "numpy", "numba", "opencv-contrib-python-headless")


def titles() -> list[str]:
    """Return the headings of the sections."""
    return [section.TITLE for section in SECTIONS]


def introduction() -> str:
    """Return the text above the parts."""
    used = ", ".join(f"{name} {versions()[name]}" for name in SHOWN_VERSIONS)
    return "\n\n".join(
        [
            "# Validation and verification",
            "`./run validation` computes all our numbers and writes this page. *Validation* asks "
            "whether the simulator agrees with the world, and *verification* whether the code "
            "does what its equations say.",
            f"Computed with simulator sources `{code_sha256()[:16]}` (SHA-256 over `sim/`, as in "
            f"the manifest of a run), {used}.",
        ]
    )


def section_text(title: str, names: list[str], figures: Path) -> str:
    """Compute one section, write its plots and return its text, headings below the section's."""
    (section,) = (section for section in SECTIONS if title == section.TITLE)
    text: str = section.section(names, figures)
    return text.replace("\n### ", "\n#### ")


def page(texts: dict[str, str]) -> str:
    """Return the page with these texts of its sections, by title."""
    blocks = [introduction()]
    for part in PARTS:
        blocks.append(f"## {part.title}\n\n{part.text}")
        blocks += [f"### {one.TITLE}\n\n{texts[one.TITLE]}" for one in part.sections]
    return "\n\n".join(blocks) + "\n"


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
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_text(page(texts), encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    """Write the page and say where it is."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=DOCS / "validation.md")
    options = parser.parse_args(arguments)
    write(options.out)
    print(f"wrote {options.out}")
    return 0

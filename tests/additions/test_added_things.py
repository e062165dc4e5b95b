"""A thing is shown everywhere as soon as the registry has it: no list elsewhere names it.

A service in a process of its own has one more line in each registry (`service`, `things`).
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from html import unescape
from pathlib import Path
from pkgutil import resolve_name

import pytest

from seamark.formats.registry import FORMATS
from seamark.sandbox.languages import LANGUAGES
from seamark.server.pages.administration import ADMIN_PAGES
from seamark.sim import registry
from seamark.sim.vehicles import load
from tests.additions.things import FILES

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
Shown = dict[str, str]  # address -> text


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory, _valkey: str) -> Shown:
    folder = tmp_path_factory.mktemp("additions")
    for name, text in FILES.items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    data = folder / "data"
    subprocess.run(
        [sys.executable, "-m", "tests.additions.service", str(data), _valkey],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": f"{ROOT}:{folder}"},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    found: Shown = json.loads((data / "shown.json").read_text("utf-8"))
    return {address: " ".join(unescape(text).split()) for address, text in found.items()}


# kind of thing -> what pages show of all that there are, what they show of the added one
LISTED: dict[str, tuple[Sequence[str], str]] = {
    "languages": (
        [one.short_label for one in LANGUAGES.values() if len(one.label) > 2],
        "Formulas",
    ),
    "names of languages": ([f'"{name}"' for name in LANGUAGES], '"formulas"'),
    "vehicles": ([load(name).title for name in registry.VEHICLES], "Dory with oars"),
    "names of vehicles": ([f'"{name}"' for name in registry.VEHICLES], '"dory"'),
    "benchmarks": ([registry.benchmark(name).title for name in registry.BENCHMARKS], "harbour"),
    "names of benchmarks": ([*registry.BENCHMARKS], "harbour-v1"),
    "files of formats": ([one.file for one in FORMATS.values()], "telemetry.knots"),
    "trackers": (
        [resolve_name(path).label for path in registry.TRACKERS.values()],
        "Drifting corners",
    ),
    "pages of the administration": (
        [f">{one.label}</a>" for one in ADMIN_PAGES],
        '<a href="/admin/weather">Weather at sea</a>',
    ),
    "controllers": (
        [resolve_name(path).label for path in registry.CONTROLLERS.values()],
        "Full ahead",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", LISTED)
def test_what_lists_all_that_there_are_lists_the_added_one(kind: str, shown: Shown) -> None:
    known, added = LISTED[kind]
    lists = {address: text for address, text in shown.items() if all(one in text for one in known)}

    assert lists
    assert [address for address, text in lists.items() if added not in text] == []


EXPECTED = {  # address -> what it shows of the added things
    "/": ("harbour-v1", "Formulas"),
    "/benchmarks/": ("Station keeping in a harbour", "keeps station in a harbour?"),
    "/benchmarks/harbour-v1": ("Dory with oars",),
    "/leaderboards/harbour-v1": ("Full ahead", "Drifting corners"),
    "/submit/harbour-v1": (
        *("Dory with oars", "Drifting corners", "Full ahead", "Formulas (one for each axis)"),
        'data-program-template="formulas" data-file="controller.formulas" data-syntax="text"',
    ),
    "/first-controller": ("Formulas",),
    "/status": ("Formulas (one for each axis)",),
    "/docs/languages": ("Starter in Formulas", "gain * error_x"),
    "/docs/box": ("Nothing but <code>min</code>",),
    "/docs/metrics": ("Score of harbour-v1",),
    "/docs/physics": ("A small boat below the water.", "/docs/physics/dory.urdf"),
    "/admin/rejudgements/new": ("harbour-v1", "Formulas (one for each axis)"),
    "/admin/workers": ("Formulas (one for each axis)",),
    "/admin/weather": ("Fog",),
    "/runs/1": (
        *("Dory with oars", "Drifting corners"),
        *("/api/v1/runs/1/telemetry.knots", "for sailors, on a rope"),
    ),
    "/api/v1/openapi.json": ("telemetry.knots", "Download all rows so far as knots."),
    "seamark export --help": ("knots", "for sailors, on a rope"),
    "/api/v1/runs/1/scene.json": ('"capsule"', "#e9f0f2"),
    "/api/v1/benchmarks": ("harbour-v1",),
    "/api/v1/environment": ("formulas",),
    "environments of Gymnasium": ("seamark/Harbour-v1",),
    "starters": ("formulas",),
    "parameters": ("gain",),
}


@pytest.mark.parametrize("address", EXPECTED)
def test_a_page_shows_the_added_things_that_its_reader_looks_for(
    address: str, shown: Shown
) -> None:
    assert [words for words in EXPECTED[address] if words not in shown[address]] == []


def test_an_added_page_of_the_administration_is_closed_to_others(shown: Shown) -> None:
    assert "Fog" not in shown["weather for a guest"]


NAMES = {*LANGUAGES, *registry.VEHICLES, *registry.BENCHMARKS, *registry.TRACKERS} - {"box", "c"}
COMPARED = re.compile(r"""(?:[=!]=|startsWith\(|\bin \()\s*["']([^"']+)["']""")


@pytest.mark.parametrize("suffix", [".html", ".js"])
def test_no_template_or_script_asks_for_the_name_of_a_thing(suffix: str) -> None:
    files = [
        path for path in (ROOT / "templates").rglob(f"*{suffix}") if "vendor" not in path.parts
    ]
    assert files

    asked = {
        f"{path.name}: {name}"
        for path in files
        for name in COMPARED.findall(path.read_text("utf-8"))
        if name in NAMES
    }

    assert asked == set()

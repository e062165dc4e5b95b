"""The documentation: text in templates, tables from the objects that the code uses."""

import importlib.metadata
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from dataclasses import fields as fields_of
from functools import lru_cache
from itertools import groupby
from typing import Any

from flask import (
    Blueprint,
    Response,
    abort,
    redirect,
    render_template,
    request,
    url_for,
)
from flask.typing import ResponseReturnValue

from seamark.programs import trial_limits
from seamark.programs.arm_helpers import helper
from seamark.programs.failure_reasons import DESCRIPTIONS
from seamark.programs.preparation import TEXT_MAX_BYTES
from seamark.sandbox.languages import (
    DEFAULT_LANGUAGE,
    LANGUAGES,
    editor_starters,
)
from seamark.sandbox.languages.inside.wire import MAX_DETECTIONS, MAX_LABEL_BYTES
from seamark.sandbox.languages.language import CONTROLLER, DETECTOR, TRACKER
from seamark.sandbox.limits import COMPILING, MEANING, Limits
from seamark.server.messaging import workers
from seamark.server.pages.docs import guides, navigation, search_index
from seamark.server.pages.docs.articles import code_block, sections_of
from seamark.server.pages.docs.navigation import Entry
from seamark.server.pages.docs.search_index import SearchIndex
from seamark.server.web import known_benchmarks, own_wheel
from seamark.server.web.services import services
from seamark.server.web.site_address import site_address
from seamark.sim import registry, vehicles
from seamark.sim.benchmarks.benchmark import Benchmark
from seamark.sim.control import observation
from seamark.sim.metrics import station_keeping, tracking
from seamark.sim.physics import constants
from seamark.sim.recording import telemetry
from seamark.sim.vehicles.patterns import CLASSES, DECOYS
from seamark.sim.vehicles.urdf import urdf_of

page = Blueprint("docs", __name__, url_prefix="/docs")
_FIGURE_MAX_AGE_S = 3600
EXTRAS = {  # of pyproject.toml
    "server": "the service: seamark up, web, worker, db, user and token",
    "box": "ONNX Runtime and SciPy, which programs find in the sandbox of a server",
    "gym": "environments for Gymnasium",
    "demonstrations": "seamark demonstrations",
    "tune": "seamark tune",
    "formats": "seamark export to Parquet and MCAP",
    "ros": "seamark bridge rosbridge; seamark replay of MCAP files and ROS bags",
    "netcdf": "seamark current of NetCDF 4 files",
    "tides": "seamark current of tidal constituents",
    "plot": "pictures by seamark plot and the Python client",
    "pybullet": "PyBullet as contact engine, to compare with; Python 3.11 alone",
}
_UNITS = {"_s": "s", "_mib": "MiB", "_kib": "KiB"}


@dataclass(frozen=True, slots=True)
class Limit:
    """One limit of the sandbox."""

    name: str
    value: float
    unit: str
    meaning: str


def _start() -> dict[str, Any]:
    return {}


def _install() -> dict[str, Any]:
    host = site_address()
    paths = {
        name: url_for("download.wheel", name=own_wheel.file_name(name)) for name in own_wheel.TAGS
    }
    return {
        "version": importlib.metadata.version("seamark"),
        "wheel": f"seamark @ {host}{paths['seamark']}",
        "client": f"seamark-client @ {host}{paths['seamark-client']}",
        "server": host,
        "paths": paths,
        "extras": EXTRAS,
    }


def _controller() -> dict[str, Any]:
    return {
        "observation": observation.EVERY_FIELD,
        "per": {
            observation.PER_THRUSTER: "thruster",
            observation.PER_MOTOR: "joint with a motor",
            observation.PER_FEELER: "part of the hand",
        },
        "booleans": observation.BOOLEANS,
        "command": observation.COMMAND,
        "archive": Limits(),
        "example": editor_starters(CONTROLLER)[DEFAULT_LANGUAGE].text(),
        "limits": list(limits_of(trial_limits.for_trial(_usual_duration_s()))),
        "duration_s": _usual_duration_s(),
        "per_simulated_s": trial_limits.CPU_PER_SIMULATED_S,
        "text_max": TEXT_MAX_BYTES,
        "upload_max": services().settings.upload_max_bytes,
    }


def _usual_duration_s() -> float:
    benchmark = known_benchmarks.first()
    return benchmark.trial_duration_s(benchmark.read({}))


def limits_of(limits: Limits) -> Iterator[Limit]:
    """Return each limit with what happens when a program reaches it."""
    values = asdict(limits)
    for field in fields_of(limits):
        end = next((end for end in _UNITS if field.name.endswith(end)), "")
        label = field.name.removesuffix(end).replace("_", " ")
        meaning = MEANING.get(field.name, "")
        yield Limit(label, values[field.name], _UNITS.get(end, ""), meaning)


def _tracker() -> dict[str, Any]:
    benchmark = next(
        each for each in map(registry.benchmark, registry.BENCHMARKS) if each.role == "tracker"
    )
    duration = benchmark.trial_duration_s(benchmark.read({}))
    return {
        "benchmark": benchmark,
        "example": editor_starters(TRACKER)[DEFAULT_LANGUAGE].text(),
        "limits": list(limits_of(trial_limits.for_trial(duration))),
        "duration_s": duration,
        "far_px": tracking.FAR_PX,
        "lost_px": tracking.LOST_PX,
    }


def _detector() -> dict[str, Any]:
    return {
        "example": editor_starters(DETECTOR)[DEFAULT_LANGUAGE].text(),
        "classes": CLASSES,
        "decoys": DECOYS,
        "most": MAX_DETECTIONS,
        "label_bytes": MAX_LABEL_BYTES,
        "limits": list(limits_of(trial_limits.for_trial(_usual_duration_s()))),
        "duration_s": _usual_duration_s(),
    }


def _languages() -> dict[str, Any]:
    return {
        "guide": guides.html("languages.md"),
        "starters": _starters(),
        "compiling": COMPILING,
        "limits": Limits(),
    }


@lru_cache(maxsize=1)
def _starters() -> list[tuple[str, str]]:
    """Return heading and HTML of the starters; colouring them takes 0.16 s."""
    return [(heading, code_block(text, syntax)) for heading, text, syntax in _starter_texts()]


def _starter_texts() -> Iterator[tuple[str, str, str]]:
    """Iterate over heading, text and syntax of the starters, but the first one.

    That one is on the page about controllers. Files beside them come last, and once: companions,
    and the kinematics of arms.
    """
    shown = {}
    first = LANGUAGES[DEFAULT_LANGUAGE].starter(CONTROLLER)
    for language in LANGUAGES.values():
        for starter in language.starters:
            if starter.role != CONTROLLER or starter is first:
                continue
            heading = starter.heading or f"Starter in {language.short_label}"
            arm = " that moves an arm" if starter.moves_arm else ""
            yield heading + arm, starter.text(), language.syntax
            for name, path in starter.companions.items():
                shown[name] = f"The file {name}", path.read_text("utf-8"), language.syntax
        for name, content in helper(language.name).items():
            shown[name] = f"The file {name}", content.decode(), language.syntax
    yield from shown.values()


def _box() -> dict[str, Any]:
    with services().database.reading() as session:
        environments = workers.environments(session)
    return {
        "environments": [(LANGUAGES[one.language], one) for one in environments],
        "memory_mib": Limits().memory_mib,
    }


def _runs() -> dict[str, Any]:
    return {"reasons": DESCRIPTIONS, "settings": services().settings}


def _physics() -> dict[str, Any]:
    return {
        "vehicles": [vehicles.load(name) for name in registry.VEHICLES],
        "tags": vehicles.TAGS,
        "constants_of": constants.GROUPS,
        "benchmarks": known_benchmarks.labels(),
    }


def _metrics() -> dict[str, Any]:
    return {
        "guide": guides.html("measures.md"),
        "scores": list(_scores()),
        "held_m": station_keeping.HELD_P95_M,
        "far_px": tracking.FAR_PX,
        "near_px": tracking.NEAR_PX,
        "failed_percent": tracking.FAILED_PERCENT,
        "tracker_held_percent": tracking.HELD_PERCENT,
    }


def _scores() -> Iterator[tuple[Benchmark, str]]:
    """Iterate over the benchmarks with the part of their explanation that is about the score."""
    for name in registry.BENCHMARKS:
        explanation, _ = guides.section(guides.BENCHMARKS, name)
        parts = {title: body for _, title, body in guides.folded(explanation)}
        yield registry.benchmark(name), parts.get("Score", "")


def _telemetry() -> dict[str, Any]:
    columns = [(one.name, one.unit, one.meaning) for one in telemetry.COLUMNS]
    arm, work = _alike(telemetry.ARM_COLUMNS), _alike(telemetry.WORK_COLUMNS)
    search, route = _alike(telemetry.SEARCH_COLUMNS), _alike(telemetry.ROUTE_COLUMNS)
    return {
        "columns": columns,
        "arm_columns": arm,
        "work_columns": work,
        "search_columns": search,
        "route_columns": route,
        "dock_columns": _alike(telemetry.DOCK_COLUMNS),
        "object_columns": _alike(_numbered("object", telemetry.OBJECT_COLUMNS)),
        "answer_columns": _alike(_numbered("answer", telemetry.ANSWER_COLUMNS)),
        "answers": telemetry.ANSWERS,
        "classes": [*CLASSES],
        "decoys": [*DECOYS],
    }


def _numbered(name: str, columns: Iterable[telemetry.Column]) -> Iterator[telemetry.Column]:
    """Iterate over columns of which rows have several sets, with N for the number of the set."""
    return (replace(column, name=f"{name}_N_{column.name}") for column in columns)


def _alike(columns: Iterable[telemetry.Column]) -> list[tuple[str, str, str]]:
    """Return names, unit and meaning of columns; those that mean the same are one row."""
    alike = groupby(columns, key=lambda one: (one.unit, one.meaning))
    return [(_from_to(each), *key) for key, each in alike]


def _from_to(columns: Iterable[telemetry.Column]) -> str:
    names = [column.name for column in columns]
    return names[0] if len(names) == 1 else f"{names[0]} to {names[-1]}"


# name -> title, values for its template
PAGES: Mapping[str, tuple[str, Callable[[], dict[str, Any]]]] = {
    "start": ("Your first controller in five minutes", _start),
    "install": ("Install the command line", _install),
    "controller": ("Write a controller", _controller),
    "tracker": ("Write a tracker", _tracker),
    "detector": ("Write a detector", _detector),
    "languages": ("Languages", _languages),
    "box": ("In the box", _box),
    "runs": ("Runs and failures", _runs),
    "metrics": ("Metrics and scores", _metrics),
    "telemetry": ("Telemetry", _telemetry),
    "physics": ("Physics and parameters", _physics),
}
# Addresses of earlier versions -> page and section that has their subject now
MOVED = {"native": ("languages", "c-and-c"), "measures": ("metrics", "")}


@page.get("/")
def index() -> ResponseReturnValue:
    """Redirect to the first page."""
    return redirect(url_for("docs.show", name="start"))


@page.get("/<name>")
def show(name: str) -> ResponseReturnValue:
    """Show one page of the documentation."""
    if name in MOVED:
        target, anchor = MOVED[name]
        return redirect(url_for("docs.show", name=target, _anchor=anchor or None), code=301)
    if name not in PAGES:
        abort(404)
    return _page(name)


@page.get("/guides/<path:name>")
def guide(name: str) -> ResponseReturnValue:
    """Show a page of docs/, or a figure or text file that a page links to."""
    if name in navigation.MERGED:
        return redirect(url_for("docs.show", name=navigation.MERGED[name]), code=301)
    if name in guides.titles():
        return _guide(name)
    if name not in guides.attachments():
        abort(404)
    data, media_type = guides.attachment(name)
    response = Response(data, content_type=media_type)
    response.add_etag()
    response.cache_control.max_age = _FIGURE_MAX_AGE_S
    return response.make_conditional(request)


@page.get("/search")
def search() -> ResponseReturnValue:
    """Show the sections of all pages that have the words of the query."""
    query = request.args.get("q", "").strip()[: search_index.QUERY_MAX]
    articles = _index().find(query)
    return _rendered("docs/search.html", title="Search", here="", query=query, articles=articles)


@lru_cache(maxsize=1)
def _index() -> SearchIndex:
    """Return the search index, which the first search of a process makes."""
    return SearchIndex(
        (_address(entry), entry.title, sections_of(_article(entry)))
        for entry in navigation.entries(_titles())
    )


def _address(entry: Entry) -> str:
    endpoint = "docs.guide" if entry.is_guide else "docs.show"
    return url_for(endpoint, name=entry.name)


def _article(entry: Entry) -> str:
    shown = _guide(entry.name) if entry.is_guide else _page(entry.name)
    return shown.partition("</h1>")[2].partition("</article>")[0]


def _page(name: str) -> str:
    title, values = PAGES[name]
    return _rendered(f"docs/{name}.html", title=title, here=name, **values())


def _guide(name: str) -> str:
    title, html = guides.titles()[name], guides.html(name)
    return _rendered("docs/guide.html", title=title, here=name, html=html)


def _titles() -> dict[str, str]:
    return {name: title for name, (title, _) in PAGES.items()}


def _rendered(template: str, **values: Any) -> str:
    """Return a page with the navigation list of all pages."""
    groups = navigation.groups(_titles())
    return render_template(template, groups=groups, address=_address, **values)


@page.get("/physics/<name>.urdf")
def urdf(name: str) -> ResponseReturnValue:
    """Return a vehicle's URDF, as loaded by the contact engine."""
    if name not in registry.VEHICLES:
        abort(404)
    response = Response(urdf_of(vehicles.load(name)), mimetype="application/xml")
    response.headers["Content-Disposition"] = f'attachment; filename="{name}.urdf"'
    return response

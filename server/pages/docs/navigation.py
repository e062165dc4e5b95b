"""The order of the documentation: its groups of pages, and which guides are shown within a page."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from seamark.server.pages.docs import guides

# guide -> page of the site that shows it, with tables from the objects that the code uses
MERGED: Mapping[str, str] = {"languages.md": "languages", "measures.md": "metrics"}
# A name with a suffix is a guide in docs/; the others are pages of the site.
_GROUPS: Mapping[str, Sequence[str]] = {
    "Get started": (
        *("start", "tutorial.md", "install", "command-line.md", "tuning.md", "python-client.md"),
        *("typescript-client.md", "cpp-client.md"),
    ),
    "Write a program": (
        *("controller", "tracker", "detector", "languages", "box", "protocol.md"),
        *("bridges.md", "training.md"),
    ),
    "Runs and results": (
        *("runs", "metrics", "telemetry", "compare.md", "formats.md", "ranking.md"),
        *("publishing.md", "datasets.md", "logs.md"),
    ),
    "Benchmarks and models": (
        *("benchmarks.md", "physics", "currents.md", "vehicles.md", "identification.md"),
        *("camera.md", "sonar.md", "controllers.md", "trackers.md", "trackers-table.md"),
        *("visibility.md", "validation.md", "measurements.md"),
    ),
    "For teachers and operators": (
        *("classes.md", "competitions.md", "hosting.md", "security.md", "scaling.md"),
        "decisions.md",
    ),
}


@dataclass(frozen=True, slots=True)
class Entry:
    """A page in the navigation."""

    name: str
    title: str

    @property
    def is_guide(self) -> bool:
        """Whether the page is a file in docs/."""
        return self.name in guides.titles()


def groups(pages: Mapping[str, str]) -> Mapping[str, Sequence[Entry]]:
    """Return title -> pages of each group; guides without a place are in the last one.

    Parameters
    ----------
    pages
        Name -> title of the pages that are no guides.
    """
    titles = {**pages, **guides.titles()}
    placed = {name for names in _GROUPS.values() for name in names}
    last = tuple(name for name in guides.titles() if name not in placed | set(MERGED))
    groups = dict(_GROUPS)
    groups[[*_GROUPS][-1]] = (*[*_GROUPS.values()][-1], *last)
    return {
        title: [Entry(name, titles[name]) for name in names if name in titles]
        for title, names in groups.items()
    }


def entries(pages: Mapping[str, str]) -> Iterator[Entry]:
    """Iterate over all pages in the order of the navigation."""
    for group in groups(pages).values():
        yield from group

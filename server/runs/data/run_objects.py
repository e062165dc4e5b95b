"""The objects of a run: its files, and while it runs the parts of those that grow.

`runs/<id // 1000>/<id>/<attempt>/` has the names of `files`. Until the end,
`parts/<file>/<generation>-<offset>` has pieces of telemetry and log in their place: a trial that
starts again takes rows back and begins a new generation. `complete` is stored last.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from seamark.server.runs.data.files import RUNS_PER_FOLDER
from seamark.server.storage.objects import Object, Objects

GROWING = ("telemetry.f64", "log.txt")
REPLACED = ("columns.json", "log.tail")  # each time as a whole, while the run goes on
COMPLETE = "complete"
_PARTS = "parts"


@dataclass(frozen=True, slots=True, order=True)
class Part:
    """A piece of a file, `offset` bytes from its start."""

    generation: int
    offset: int
    path: str
    size: int


@dataclass(frozen=True, slots=True)
class Attempt:
    """What the storage has of one attempt."""

    files: Mapping[str, Object]
    parts: Mapping[str, Sequence[Part]]  # file -> in the order in which they were written

    @property
    def complete(self) -> bool:
        """Whether the worker has stored all files, and will not store another."""
        return COMPLETE in self.files

    @property
    def changed_at(self) -> float:
        """When the last of the files was stored; parts are as old as their run."""
        return max((one.changed_at for one in self.files.values()), default=0.0)

    @property
    def size(self) -> int:
        """How many bytes the files take."""
        parts = sum(part.size for parts in self.parts.values() for part in parts)
        return sum(one.size for one in self.files.values()) + parts


def folder(run_id: int, attempt: int | None = None) -> str:
    """Return the path of the objects of a run, or of one attempt."""
    root = f"runs/{run_id // RUNS_PER_FOLDER}/{run_id}"
    return root if attempt is None else f"{root}/{attempt}"


def part(run_id: int, attempt: int, file: str, *, generation: int, offset: int) -> str:
    """Return the path of a part."""
    return f"{folder(run_id, attempt)}/{_PARTS}/{file}/{generation:06d}-{offset:015d}"


def attempts(objects: Objects, run_id: int) -> dict[int, Attempt]:
    """Return the attempts of a run that have objects."""
    return grouped(objects.list(folder(run_id))).get(run_id, {})


def grouped(listing: Sequence[Object]) -> dict[int, dict[int, Attempt]]:
    """Return run -> attempt -> objects, of the listing of a folder of runs."""
    files = defaultdict[tuple[int, int], dict[str, Object]](dict)
    parts = defaultdict[tuple[int, int], dict[str, list[Part]]](lambda: defaultdict(list))
    for one in listing:
        _, _, run_id, attempt, *names = one.path.split("/")
        key = int(run_id), int(attempt)
        if names[0] == _PARTS:
            generation, _, offset = names[2].partition("-")
            part = Part(int(generation), int(offset), one.path, one.size)
            parts[key][names[1]].append(part)
        else:
            files[key][names[0]] = one
    runs = defaultdict[int, dict[int, Attempt]](dict)
    for key in sorted({*files, *parts}):
        ordered = {name: sorted(listed) for name, listed in parts[key].items()}
        runs[key[0]][key[1]] = Attempt(files[key], ordered)
    return runs


def remove(objects: Objects, run_id: int, attempt: int | None = None) -> None:
    """Remove the objects of a run, or of one attempt."""
    objects.delete([one.path for one in objects.list(folder(run_id, attempt))])


def remove_before(objects: Objects, run_id: int, attempt: int) -> None:
    """Remove the objects of earlier attempts, whose workers have lost the run."""
    for earlier in attempts(objects, run_id):
        if earlier < attempt:
            remove(objects, run_id, earlier)

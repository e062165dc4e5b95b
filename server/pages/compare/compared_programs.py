"""The programs of compared runs: in which lines they differ, for those who may read them."""

from collections.abc import Sequence
from dataclasses import dataclass

from flask import g

from seamark.server.accounts.permissions import Action, can
from seamark.server.programs import store
from seamark.server.programs.source_differences import FileDifference, differences, files_of
from seamark.server.runs.showing.views import RunView
from seamark.server.storage import storage
from seamark.server.storage.storage import StorageUnavailable
from seamark.server.web.services import services


@dataclass(frozen=True, slots=True, kw_only=True)
class ProgramDifference:
    """What the program of a run changes in that of another run."""

    run: int
    other: int
    sentence: str  # what there is no line for
    files: tuple[FileDifference, ...] = ()


def program_differences(runs: Sequence[RunView]) -> list[ProgramDifference]:
    """Return how the programs of runs differ from the first one that the viewer may read.

    Runs without an uploaded program are left out. Of programs that the viewer may not read only
    whether they are the same is told, as their SHA-256 on the page of a run does.
    """
    uploaded = [run for run in runs if run.program_sha256 is not None]
    if len(uploaded) < 2:
        return []
    other = next((run for run in uploaded if _is_readable(run)), uploaded[0])
    return [_difference(run, other) for run in uploaded if run is not other]


def _is_readable(run: RunView) -> bool:
    return can(g.viewer, Action.VIEW_PROGRAM, run)


def _difference(run: RunView, other: RunView) -> ProgramDifference:
    sentence, files = _comparison(run, other)
    return ProgramDifference(run=run.id, other=other.id, sentence=sentence, files=files)


def _comparison(run: RunView, other: RunView) -> tuple[str, tuple[FileDifference, ...]]:
    if run.program_sha256 == other.program_sha256:
        return "The programs are the same.", ()
    hidden = [each.id for each in (other, run) if not _is_readable(each)]
    if hidden:
        return _hidden(hidden), ()
    try:
        return "", differences(_files(other), _files(run))
    except FileNotFoundError:
        return "The programs differ. One of them was deleted.", ()
    except StorageUnavailable:
        return "The programs differ. They cannot be read at the moment; try again later.", ()


def _hidden(ids: Sequence[int]) -> str:
    if len(ids) > 1:
        return "The programs differ. Their owners did not publish the sources."
    return f"The programs differ. The owner of run {ids[0]} did not publish the source."


def _files(run: RunView) -> dict[str, bytes]:
    storage.require_readable(services().settings)
    content = store.read(services().settings, run.program_sha256 or "")
    return files_of(run.program_name or "program", content)

"""What differs between the archive of a run and the run computed again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from seamark.sim.recording import telemetry
from seamark.sim.recording.telemetry import STEP_US, Rows

if TYPE_CHECKING:
    from seamark.formats.archive_reading import ArchivedRun, Manifest
    from seamark.worker.ipc.outcomes import RunOutcome

_PARAMETERS = "parameters"  # of the program, in a configuration
_SHOWN = 60  # characters of a value
_HASH_SHOWN = 12


def of_inputs(
    archived: ArchivedRun, program: bytes | None, parts: Mapping[str, bytes]
) -> list[str]:
    """Return what of the archive contradicts its manifest, before anything is computed.

    Parameters
    ----------
    program, parts
        In normal form; the parts are further programs by their roles.
    """
    manifest = archived.manifest
    stated = manifest.configuration | (
        {_PARAMETERS: manifest.parameters} if manifest.parameters else {}
    )
    lines = [
        f"configuration: {name} is {here} in config.json and {there} in the manifest"
        for name, there, here in _unequal(stated, archived.config)
    ]
    stored = {"program": program} | dict(parts)
    digests = {"program": manifest.program_sha256} | manifest.parts
    for what, content in stored.items():
        digest = None if content is None else hashlib.sha256(content).hexdigest()
        if digest != digests[what]:
            lines.append(
                f"{what}: the SHA-256 is {_short(digest)} and {_short(digests[what])} "
                "in the manifest"
            )
    return lines


def of_software(there: Manifest, here: Mapping[str, Any]) -> list[str]:
    """Return in what the software differs that computed the run, given the manifest from here."""
    lines = [
        f"version of {name}: {before} in the archive, {now} here"
        for name, before, now in _unequal(there.versions, here["versions"])
    ]
    if there.code_sha256 != here["code_sha256"]:
        before, now = _short(there.code_sha256), _short(here["code_sha256"])
        lines.append(f"code of the simulator: {before} in the archive, {now} here")
    if there.contacts != here["contacts"]:
        before, now = _engine(there.contacts), _engine(here["contacts"])
        lines.append(
            f"contacts: {before} in the archive, {now} here; a run that touched something differs"
        )
    return lines


def _engine(contacts: str) -> str:
    """Return what a manifest says of contacts, in words."""
    # Until 2026-11 PyBullet was the only engine, and "off" meant that it was not installed.
    names = {"simulated": "computed by PyBullet", "pybullet": "computed by PyBullet"}
    return (names | {"seamark": "computed by Seamark"}).get(contacts, contacts)


def of_processor(there: Manifest, here: Mapping[str, Any]) -> list[str]:
    """Return in what the processors differ, if the result may depend on them."""
    if there.same_bits_on_every_cpu or there.cpu == here["cpu"]:
        return []
    before, now = there.cpu.get("model", "unknown"), here["cpu"]["model"]
    return [
        f"processor: {before} in the archive, {now} here; the result of this run may depend on it"
    ]


def of_results(archived: ArchivedRun, outcome: RunOutcome, rows: Rows) -> list[str]:
    """Return in what the results differ: digest, metrics, and the first number of the telemetry."""
    lines = []
    if archived.manifest.digest != outcome.digest:
        before, now = _short(archived.manifest.digest), _short(outcome.digest)
        lines.append(f"digest: {before} in the archive, {now} here")
    # As JSON has them: the archive's numbers have been through it.
    now = json.loads(json.dumps(outcome.metrics))
    if archived.metrics is not None and archived.metrics != now:
        name, before, after = next(_unequal(archived.metrics, now or {}))
        lines.append(f"metrics: {name} is {before} in the archive and {after} here")
    return lines + _first_number(archived, rows)


def _first_number(archived: ArchivedRun, rows: Rows) -> list[str]:
    """Return where the telemetry first differs; the wall time of the program does not count."""
    known = telemetry.names(rows.shape[1])
    at = 0
    for names, before in archived.rows():
        if names != known:
            return [f"telemetry: the columns are {len(names)} others than the {len(known)} here"]
        now = rows[at : at + len(before)]
        if cell := _first_unequal(before[: len(now)], now):
            row, column = cell
            return [_described(before[row], now[row], column, at + row)]
        at += len(before)
        if at > len(rows):
            break
    if at != len(rows):
        more = "more than " if at > len(rows) else ""
        return [f"telemetry: {more}{min(at, len(rows))} rows in the archive, {len(rows)} here"]
    return []


def _first_unequal(before: Rows, now: Rows) -> tuple[int, int] | None:
    unequal = (before != now) & ~(np.isnan(before) & np.isnan(now))
    unequal[:, STEP_US] = False
    cells = np.argwhere(unequal)
    return (int(cells[0][0]), int(cells[0][1])) if len(cells) else None


def _described(before: Rows, now: Rows, column: int, at: int) -> str:
    named = telemetry.columns(len(now))[column]
    trial, t = int(now[telemetry.INDEX["trial"]]), now[telemetry.INDEX["t"]]
    unit = f" [{named.unit}]" if named.unit else ""
    return (
        f"telemetry: first in row {at} from 0 (trial {trial}, t = {t:g} s), column "
        f"{named.name}{unit}: {float(before[column])} in the archive, {float(now[column])} here"
    )


def _unequal(
    there: Mapping[str, Any], here: Mapping[str, Any], path: Sequence[str] = ()
) -> Iterator[tuple[str, str, str]]:
    """Yield name and both values of what differs, into objects but not into lists."""
    for name in sorted({*there, *here}):
        one, other = there.get(name), here.get(name)
        if isinstance(one, dict) and isinstance(other, dict):
            yield from _unequal(one, other, (*path, name))
        elif one != other:
            yield ".".join((*path, name)), _value(one), _value(other)


def _value(value: object) -> str:
    text = json.dumps(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"


def _short(digest: str | None) -> str:
    return "missing" if digest is None else f"{digest[:_HASH_SHOWN]}…"

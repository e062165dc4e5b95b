"""The process that reads one upload: limited in CPU time, memory and descriptors, then gone.

Protocol: a line of JSON with the request and then the upload on standard input; a line of JSON
with the answer and then the content on standard output. For a vehicle, the answer is the fields of
a `VehicleReport`, without a content; for another file that a setting can name, it says why it is
refused, if it is, and the content is the file to keep.
Started by `reader`.
"""

import json
import os
import resource
import sys
from typing import Any

from seamark.programs.preparation import UploadRejected, prepare
from seamark.sandbox.printable_text import printable_text

CPU_S = 4  # parsing 512 KiB of ordinary Python takes 0.5 s, an archive of 8 MiB 0.3 s
MEMORY_MIB = 512  # of address space; the tree of 512 KiB of Python takes up to 250 MiB
OPEN_FILES = 16
NICENESS = 10  # pages go first


def main() -> None:
    """Answer one request."""
    _limit()
    request = json.loads(sys.stdin.buffer.readline())
    source = sys.stdin.buffer.read()
    if "vehicle" in request:
        answer, content = _vehicle(source), b""
    elif "setting" in request:
        answer, content = _file(request["setting"], source)
    else:
        answer, content = _answer(source, request["filename"], request["role"])
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n" + content)


def _answer(source: bytes, filename: str, role: str) -> tuple[dict[str, Any], bytes]:
    try:
        prepared = prepare(source, filename, role=role)
    except UploadRejected as reason:
        return {"refused": str(reason)}, b""
    diagnostics = [one.to_json() for one in prepared.diagnostics]
    answer: dict[str, Any] = {"name": prepared.name, "language": prepared.language}
    answer |= {"diagnostics": diagnostics}
    return answer | {"parameters": [p.to_json() for p in prepared.parameters]}, prepared.content


def _vehicle(content: bytes) -> dict[str, Any]:
    """Return what is to be said of the file of a vehicle."""
    # Here: only some uploads need NumPy, which takes half as long to load as all the rest.
    from seamark.sim.vehicles import own, report  # noqa: PLC0415
    from seamark.sim.vehicles.plausibility import findings  # noqa: PLC0415
    from seamark.sim.vehicles.reading import VehicleInvalid  # noqa: PLC0415

    try:
        vehicle = own.read(content)
    except VehicleInvalid as invalid:
        return {"errors": list(map(printable_text, invalid.errors))}
    told = findings(vehicle)
    errors = [printable_text(one.text) for one in told if one.grade == "error"]
    return {
        "name": own.name_of(vehicle, content),
        "title": printable_text(vehicle.title),
        "errors": errors,
        "warnings": [printable_text(one.text) for one in told if one.grade == "warning"],
        "figures": [] if errors else list(map(printable_text, report.figure_lines(vehicle))),
        "defaults": dict(vehicle.defaults),
    }


def _file(setting: str, content: bytes) -> tuple[dict[str, Any], bytes]:
    """Return why a file that a setting can name is refused, empty if it is not, and it as kept."""
    from seamark.sim.files.library import FileInvalid  # noqa: PLC0415 - as above
    from seamark.sim.settings.own_files import LIBRARIES  # noqa: PLC0415

    try:
        return {"refused": ""}, LIBRARIES[setting].converted(content)
    except FileInvalid as invalid:
        return {"refused": str(invalid)}, b""


def _limit() -> None:
    """Limit this process; what it has used for its start counts."""
    os.nice(NICENESS)
    for kind, most in (
        (resource.RLIMIT_CPU, CPU_S),
        (resource.RLIMIT_AS, MEMORY_MIB << 20),
        (resource.RLIMIT_NOFILE, OPEN_FILES),
        (resource.RLIMIT_FSIZE, 0),
        (resource.RLIMIT_CORE, 0),
    ):
        resource.setrlimit(kind, (most, most))


if __name__ == "__main__":
    main()

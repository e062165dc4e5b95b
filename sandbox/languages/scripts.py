"""Boxes whose first process is a script of `sandbox/languages/inside`."""

import compileall
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from seamark.sandbox.isolation.readable_copies import shelved
from seamark.sandbox.languages.language import Bind, Runtime
from seamark.sandbox.languages.python_host import interpreter_files

PACKAGES = "/box/python"
PACKAGE = "seamark_inside"  # the package's name inside: an upload is hardly called so


def script_runtime(
    name: str,
    *,
    arguments: Iterable[str] = (),
    binds: Iterable[Bind] = (),
    environment: Mapping[str, str],
    images: bool = False,
) -> Runtime:
    """Return what a box needs to run `main` of the script `name` with arguments, then `--`.

    The numbers of the protocol's descriptor, of processes and of MiB follow.
    """
    command, files = interpreter_files()
    inside = Path(__file__).with_name("inside")
    compileall.compile_dir(inside, quiet=2, workers=1)  # 20 ms of each start, where we may
    ours = Bind(inside, f"{PACKAGES}/{PACKAGE}")
    reached = tuple(replace(bind, source=shelved(bind.source)) for bind in (*files, ours, *binds))
    start = ("-c", f"from {PACKAGE}.{name} import main; main()")  # -m imports more
    whole = (*command, *start, *arguments, "--")
    return Runtime(whole, {**environment, "PYTHONPATH": PACKAGES}, reached, images=images)

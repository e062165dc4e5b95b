"""The manifest: all that a result depends on, and its digest."""

import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from seamark.sim.files import target_pictures
from seamark.sim.physics.water_motion import records
from seamark.sim.recording import opencv
from seamark.sim.vehicles import own

FORMAT = 1
LIBRARIES = (
    "seamark",
    "numpy",
    "numba",
    "llvmlite",
    "pybullet",
)
CPUINFO = Path("/proc/cpuinfo")
# Microarchitecture levels of the x86-64 psABI by one characteristic flag each, highest first.
X86_LEVELS = (("avx512bw", "x86-64-v4"), ("avx2", "x86-64-v3"), ("sse4_2", "x86-64-v2"))


class Configuration(Protocol):
    """What the manifest needs of a configuration."""

    def model_dump(self, *, mode: str) -> dict[str, Any]:
        """Return all settings as plain JSON values."""
        ...

    def exact(self) -> bool:
        """Return whether every x86-64 processor gives the same bits."""
        ...


def manifest(
    benchmark: str,
    config: Configuration,
    *,
    seed: int | None,
    seeds: Sequence[int] | None = None,
    trials: int,
    controller: str,
    program_sha256: str | None = None,
    digest: str,
    **more: object,
) -> dict[str, Any]:
    """Return the manifest of a run as plain JSON values.

    Parameters
    ----------
    seed : int or None
        Of all trials; None for a ranked run.
    seeds : sequence of int or None
        Of each trial of a ranked run, where they concern this submission alone. None if they are
        hidden, because other runs have the same ones, or if there is only one.
    controller : str
        Name of a built-in controller or of the bridge that connected a program, or "upload"
        together with the program's SHA-256.
    digest : str
        Of the telemetry of all trials in order.
    more
        Further entries, unchanged.

    A run with a user's own vehicle has that vehicle's file (`vehicle_file`), one with a user's own
    record of currents that record's (`current_file`), and one with a user's own picture on the
    target that picture's (`target_file`).

    An uploaded program may use BLAS, NumPy's vectorised functions or the C library's mathematics,
    which choose their code by the processor: `same_bits_on_every_cpu` is false for all uploads.
    """
    configuration = config.model_dump(mode="json")
    vehicle = own.file_of(configuration.get(own.SETTING))
    files = {
        library.entry: library.file_of(configuration.get(library.setting))
        for library in (records.LIBRARY, target_pictures.LIBRARY)
    }
    return {
        "format": FORMAT,
        "benchmark": benchmark,
        "configuration": configuration,
        "seed": seed,
        "seeds": None if seeds is None else list(seeds),
        "trials": trials,
        "controller": controller,
        "program_sha256": program_sha256,
        "digest": digest,
        "code_sha256": code_sha256(),
        "versions": versions(),
        "contacts": contacts(config),
        "cpu": cpu_class(),
        "same_bits_on_every_cpu": program_sha256 is None and config.exact(),
        **({} if vehicle is None else {"vehicle_file": vehicle._asdict()}),
        **{entry: file._asdict() for entry, file in files.items() if file is not None},
    } | more


@cache
def code_sha256() -> str:
    """Return one SHA-256 over names and contents of the simulator's sources, vehicles, records."""
    root = Path(__file__).parents[1]
    files = [*root.rglob("*.py"), *root.glob("vehicles/*.toml"), *records.SHIPPED.values()]
    total = hashlib.sha256()
    for path in sorted(files, key=lambda path: path.relative_to(root).as_posix()):
        total.update(path.relative_to(root).as_posix().encode() + b"\0")
        total.update(hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()


@cache
def versions() -> dict[str, str]:
    """Return name -> version of everything that affects a result."""
    installed = {"python": platform.python_version()}
    for name in LIBRARIES:
        try:
            installed[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            installed[name] = "not installed"
    installed[opencv.PACKAGE] = opencv.running()
    return installed


def contacts(config: Configuration) -> str:
    """Return what computes contacts with the bottom and the target, or "off".

    Until 2026-11 it was "simulated", which was by PyBullet, or "off" where that was not installed.
    """
    engine = getattr(config, "contact_engine", None)
    return "off" if engine is None else str(engine())


@cache
def cpu_class() -> dict[str, str]:
    """Return architecture, microarchitecture level and model of the processor."""
    text = CPUINFO.read_text(encoding="utf-8", errors="replace") if CPUINFO.exists() else ""
    entries: Mapping[str, str] = {
        key.strip(): value.strip()
        for key, _, value in (line.partition(":") for line in text.splitlines())
        if value
    }
    flags = set(entries.get("flags", "").split())
    machine = platform.machine()
    level = next((name for flag, name in X86_LEVELS if flag in flags), machine)
    return {"machine": machine, "level": level, "model": entries.get("model name", "unknown")}

"""Binaries for tests, compiled from their sources by the compiler of this host."""

import io
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

from seamark.sandbox.languages import fmu as fmu_language

FMUS = Path(fmu_language.__file__).with_name("conformance")
PLATFORM = {"fmi2": "linux64", "fmi3": "x86_64-linux"}


def compiled_on_host(sources: list[Path], target: Path, *options: str) -> bytes:
    """Return what the host's GCC makes of C sources."""
    command = ["gcc", "-O2", "-ffp-contract=off", *options, *map(str, sources), "-o", str(target)]
    subprocess.run([*command, "-lm"], check=True)
    return target.read_bytes()


def zipped(members: Mapping[str, bytes]) -> bytes:
    """Return a zip archive."""
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    return whole.getvalue()


def fmu(name: str, folder: Path) -> bytes:
    """Return the PI as an FMU of `name`: fmi2 or fmi3, compiled for this platform."""
    library = compiled_on_host([FMUS / f"{name}.c"], folder / "pi.so", "-shared", "-fPIC")
    members = {
        "modelDescription.xml": (FMUS / f"{name}.xml").read_bytes(),
        f"binaries/{PLATFORM[name]}/pi.so": library,
    }
    mapping = FMUS / f"{name}.json"
    if mapping.exists():
        members["extra/seamark.json"] = mapping.read_bytes()
    return zipped(members)

"""Programs that are no text: made of their sources by the compiler of this machine."""

import io
import subprocess
import zipfile
from collections.abc import Mapping
from pathlib import Path

FMUS = Path(__file__).with_name("fmus")
MODEL = Path(__file__).with_name("embedded_coder")  # as the coder lays its files out
PLATFORM = {"fmi2": "linux64", "fmi3": "x86_64-linux"}


def compiled_here(sources: list[Path], target: Path, *options: str) -> bytes:
    """Return what GCC of this machine makes of C sources."""
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
    library = compiled_here([FMUS / f"{name}.c"], folder / "pi.so", "-shared", "-fPIC")
    members = {
        "modelDescription.xml": (FMUS / f"{name}.xml").read_bytes(),
        f"binaries/{PLATFORM[name]}/pi.so": library,
    }
    mapping = FMUS / f"{name}.json"
    if mapping.exists():
        members["extra/seamark.json"] = mapping.read_bytes()
    return zipped(members)

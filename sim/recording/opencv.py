"""Which OpenCV `import cv2` brings: several packages own its folder, and the last installed wins.

`opencv-python`, `opencv-python-headless` and their contrib variants all install the folder `cv2`.
What pip lists then says nothing about what runs.
"""

import importlib.metadata
import importlib.util
import re
import sys
from pathlib import Path

PACKAGE = "opencv-contrib-python-headless"
_PINNED = re.compile(rf"{PACKAGE}==([\w.]+)")
_CONTRIB = " (without contrib modules)"


def pinned() -> str:
    """Return the version that Seamark requires."""
    lines = "\n".join(importlib.metadata.requires("seamark") or ())
    pin = _PINNED.search(lines)
    if pin is None:
        raise LookupError(f"seamark does not pin {PACKAGE}")
    return pin[1]


def running() -> str:
    """Return the version of the module `cv2`, which may be another than pip lists.

    It is read from the module's own files, so that OpenCV need not be loaded; of a module that is
    loaded, `cv2.__version__` decides.
    """
    spec = importlib.util.find_spec("cv2")
    if spec is None or spec.origin is None:
        return "not installed"
    said = _assignments(Path(spec.origin).with_name("version.py"))
    version = said.get("opencv_version", "unknown").strip("\"'")
    loaded = getattr(sys.modules.get("cv2"), "__version__", version)
    if not version.startswith(loaded):
        version = loaded
    return version + (_CONTRIB if said.get("contrib") == "False" else "")


def complaint() -> str | None:
    """Return what is wrong with the OpenCV that runs, and how to repair it; None if it is right."""
    wanted, installed = pinned(), running()
    if installed == wanted:
        return None
    owners = importlib.metadata.packages_distributions().get("cv2", [])
    others = sorted({PACKAGE, *owners})
    return (
        f"OpenCV {installed} runs in place of {wanted}: another package has replaced it. Pictures, "
        "and results that depend on them, may differ from those of a server. To repair it: "
        f"pip uninstall -y {' '.join(others)} && pip install {PACKAGE}=={wanted}"
    )


def _assignments(file: Path) -> dict[str, str]:
    """Return the names and values that a file of assignments has."""
    if not file.is_file():
        return {}
    lines = (line.partition("=") for line in file.read_text("utf-8").splitlines())
    return {name.strip(): value.strip() for name, equals, value in lines if equals}

"""The manifest names the OpenCV that runs, and another than the required one is told."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

from seamark.sim.recording import opencv
from seamark.sim.recording.manifest import versions

OTHER = 'opencv_version = "4.12.0.88"\ncontrib = False\nheadless = False\n'


@pytest.fixture
def replaced(tmp_path: Path) -> Path:
    """A folder with the `cv2` of another package, which is found first."""
    folder = tmp_path / "packages" / "cv2"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "version.py").write_text(OTHER)
    return folder.parent


def _told(packages: Path, code: str) -> str:
    path = f"import sys; sys.path.insert(0, {str(packages)!r}); "
    done = subprocess.run(
        [sys.executable, "-c", path + code], capture_output=True, text=True, check=True
    )
    return done.stdout + done.stderr


def test_the_pinned_one_runs_here_and_keeps_its_name_in_the_manifest() -> None:
    assert opencv.complaint() is None
    assert versions()[opencv.PACKAGE] == opencv.pinned() == opencv.running()
    assert opencv.pinned().startswith(cv2.__version__)


def test_another_one_is_in_the_manifest_as_what_ran(replaced: Path) -> None:
    code = "import json; from seamark.sim.recording.manifest import versions\n"

    found = json.loads(_told(replaced, f"{code}print(json.dumps(versions()))"))

    assert found["opencv-contrib-python-headless"] == "4.12.0.88 (without contrib modules)"
    assert found["numpy"] == versions()["numpy"]


def test_a_loaded_module_says_better_than_its_files_what_it_is(replaced: Path) -> None:
    code = (
        "import cv2; cv2.__version__ = '4.9.0'\n"
        "from seamark.sim.recording import opencv; print(opencv.running())"
    )

    assert _told(replaced, code) == "4.9.0 (without contrib modules)\n"


def test_without_opencv_there_is_no_version(tmp_path: Path) -> None:
    code = "from seamark.sim.recording import opencv; sys.path[:] = []; print(opencv.running())"

    assert _told(tmp_path, code) == "not installed\n"


def test_the_start_of_a_run_says_so_with_the_repair(replaced: Path) -> None:
    code = "from seamark.cli.simulator_loading import say_other_opencv as say; say()"

    found = "4.12.0.88 (without contrib modules)"

    told = _told(replaced, f"{code}; sys.stderr.flush()")

    assert told.startswith(f"OpenCV {found} runs in place of {opencv.pinned()}")
    assert f"pip install {opencv.PACKAGE}=={opencv.pinned()}" in told

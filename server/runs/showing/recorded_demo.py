"""The recorded run that is shipped, to have something to show before anything is computed.

`demo/` holds the files of a run as a worker writes them, and what else the player of a run asks
for: the scene, its textures, and small camera images for as long as this process cannot render the
images itself. `./run performance demo_recording` writes all of them.
"""

import json
import zipfile
from bisect import bisect_right
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from seamark.server.runs.data.files import RunFiles
from seamark.server.runs.record.states import RunKind, RunState
from seamark.server.runs.showing import camera_view
from seamark.server.runs.showing.camera_view import DRAWN, Drawn
from seamark.server.runs.showing.views import RunView
from seamark.server.settings import Settings
from seamark.sim import registry

FOLDER = Path(__file__).parent / "demo"
BENCHMARK, CONTROLLER, SEED = "currents-v1", "pi", 7
# The slow wave carries the vehicle off in the last level, and lets it return before that ends.
SETTINGS: dict[str, Any] = {
    "levels": [0.1, 0.3, 0.47],
    "level_duration_s": 20.0,
    "settle_s": 5.0,
    "current_wave_m_s": 0.25,
    "current_wave_period_s": 20.0,
}
IMAGE_EVERY_S = 1.0  # between two of the small camera images
SCENE, IMAGES = "scene.json", "camera.zip"
TEXTURES: dict[Literal["seabed", "target"], str] = {"seabed": "seabed.jpg", "target": "target.jpg"}
_ATTEMPT = 1


def files(folder: Path = FOLDER) -> RunFiles:
    """Return the telemetry, and the manifest with the digest."""
    return RunFiles(folder, 0, _ATTEMPT)


@lru_cache(maxsize=1)
def run() -> RunView:
    """Return the run as pages read one; it is nobody's and has no row in the database."""
    config = registry.benchmark(BENCHMARK).read(SETTINGS)
    return RunView(
        id=0, user_id=None, guest=None, user="Seamark", is_baseline=False,
        benchmark=BENCHMARK, kind=RunKind.PRACTICE, config=config.model_dump(), seed=SEED, trials=1,
        controller=CONTROLLER, program_name=None, program_sha256=None, language=None,
        title="", notes="", rerun_of=None, isolation=None, public=True, published_at=None,
        state=RunState.SUCCEEDED, cause=None, detail={}, attempt=_ATTEMPT, progress=1.0,
        queued_at=0.0, started_at=0.0, finished_at=0.0, t_simulated=config.trial_duration_s(),
        data_bytes=0, data_deleted_at=None,
    )  # fmt: skip


def digest() -> str:
    """Return the digest of the recorded telemetry, which the same run has today."""
    manifest: str = (files().manifest() or {})["digest"]
    return manifest


@lru_cache(maxsize=1)
def scene() -> dict[str, Any]:
    """Return what `scene.describe` returns for each level of the run."""
    document: dict[str, Any] = json.loads((FOLDER / SCENE).read_bytes())
    return document


def texture(part: Literal["seabed", "target"]) -> bytes:
    """Return what `scene.texture` returns for each level of the run."""
    return (FOLDER / TEXTURES[part]).read_bytes()


def camera_image(settings: Settings, t: float, drawn: Drawn = DRAWN) -> bytes:
    """Return the JPEG of the last image before simulated time `t` [s].

    At full size as soon as this process can render it at once, else a small one that is shipped.
    """
    if camera_view.is_warm():
        image = camera_view.render(settings, run(), trial=0, t=t, drawn=drawn, files=files())
        if image is not None:
            return image
    return small_image(t)


def small_image(t: float) -> bytes:
    """Return the shipped JPEG of the last image before simulated time `t` [s]."""
    images = _small_images()
    times = sorted(images)
    return images[times[max(bisect_right(times, t) - 1, 0)]]


@lru_cache(maxsize=1)
def _small_images() -> dict[float, bytes]:
    """Return simulated time [s] -> JPEG."""
    with zipfile.ZipFile(FOLDER / IMAGES) as archive:
        return {float(Path(name).stem): archive.read(name) for name in archive.namelist()}

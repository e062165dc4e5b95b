"""The recorded run that is shipped is what today's code computes."""

import json
from pathlib import Path

import pytest

from performance.figures import demo_recording
from seamark import templates
from seamark.server.runs.showing import camera_view, recorded_demo, scene
from seamark.server.settings import Settings
from seamark.sim.recording import telemetry

AGAIN = "run `./run performance demo_recording`"
SIZE_MAX = 1_250_000  # [byte] in the checkout; the wheel compresses the telemetry


def test_the_recorded_run_has_the_digest_that_the_simulator_computes_today(tmp_path: Path) -> None:
    (tmp_path / "runs").mkdir()

    demo_recording.record(tmp_path)

    today = recorded_demo.files(tmp_path)
    assert today.manifest() == {"digest": recorded_demo.digest()}, AGAIN
    shipped = recorded_demo.files()
    assert shipped.columns == telemetry.names(today.rows().shape[1]), AGAIN
    assert shipped.telemetry_path.read_bytes() == today.telemetry_path.read_bytes(), AGAIN


def test_the_shipped_scene_is_that_of_each_level(settings: Settings) -> None:
    levels = range(len(recorded_demo.SETTINGS["levels"]))

    for level in levels:
        found = scene.describe(settings, recorded_demo.run(), trial=0, level=level)
        assert json.loads(json.dumps(found)) == recorded_demo.scene(), AGAIN


def test_there_is_a_small_image_for_each_second() -> None:
    images = [recorded_demo.small_image(float(t)) for t in range(60)]

    assert len(set(images)) == 60
    assert max(map(len, images)) < 20_000
    assert recorded_demo.small_image(12.9) == images[12]


@pytest.mark.slow
def test_the_rendered_image_is_shown_as_soon_as_it_takes_no_time(settings: Settings) -> None:
    camera_view.warm_up()

    rendered = recorded_demo.camera_image(settings, 30.0)

    none = camera_view.Drawn(tracked=False, truth=False)
    assert len(rendered) > 3 * len(recorded_demo.small_image(30.0))
    assert recorded_demo.camera_image(settings, 30.0, none) != rendered


def test_what_is_shipped_for_the_demo_is_small() -> None:
    posters = Path(templates.__file__).parent / "static" / "demo"
    folders = (recorded_demo.FOLDER, posters)

    size = sum(file.stat().st_size for folder in folders for file in folder.rglob("*.*"))

    assert 100_000 < size < SIZE_MAX

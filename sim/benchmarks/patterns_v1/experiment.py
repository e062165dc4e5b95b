"""Pattern recognition over levels of optical depth, each above a bottom of its own."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from seamark.sim.benchmarks.patterns_v1.scenario import OPTICS, draw_conditions, draw_scenario
from seamark.sim.benchmarks.patterns_v1.settings import PatternsConfiguration
from seamark.sim.benchmarks.patterns_v1.training import IMAGES, labelled_scene
from seamark.sim.camera.bottom.camera import BottomCamera
from seamark.sim.detectors import Detector, make
from seamark.sim.engine.detection_loop import DetectionLoop, Oracle
from seamark.sim.engine.experiment import Level, TrialPlan, TrialScore
from seamark.sim.engine.labelled_images import LabelledImage
from seamark.sim.metrics.metric import over_run
from seamark.sim.metrics.recognition import AP, METRICS, level_metrics
from seamark.sim.metrics.tracking import held_value
from seamark.sim.numerics.statistics import area
from seamark.sim.recording.telemetry import Rows
from seamark.sim.registry import REFERENCE_DETECTORS

NO_OBJECT = "In one of the levels no object was in any image, so it has no average precision."


class Patterns:
    """A `seamark.sim.engine.experiment.Experiment` that compares detectors."""

    images_per_scene = IMAGES

    def built_in(self, name: str, config: PatternsConfiguration) -> Detector | Oracle | None:
        """Return a reference entry, or None: a level then uses the configured detector."""
        if name == Oracle.TRUTH.value:
            return Oracle.TRUTH
        return make(name) if name in REFERENCE_DETECTORS else None

    def layout(self, config: PatternsConfiguration) -> dict[str, Any]:
        """Return the role of programs."""
        return {"role": "detector"}

    def plan(self, config: PatternsConfiguration, *, seed: int, trial: int) -> TrialPlan:
        """Return that the levels run as listed, and what was drawn for each."""
        levels = range(len(config.optical_depths))
        drawn = [draw_conditions(config, seed, trial, level).as_dict() for level in levels]
        return TrialPlan(
            order=tuple(levels),
            conditions={name: [one[name] for one in drawn] for name in drawn[0]},
        )

    def level(
        self,
        config: PatternsConfiguration,
        solution: Detector | Oracle | None,
        *,
        seed: int,
        trial: int,
        level: int,
    ) -> Level:
        """Return a level at the start of its passage."""
        scenario = draw_scenario(config, seed, trial, level)
        if solution is None:
            solution = make(config.detector, **config.detector_options())
        return DetectionLoop(
            config, scenario.path, scenario.camera, solution, trial=trial, level=level
        )

    def camera(
        self, config: PatternsConfiguration, *, seed: int, trial: int, level: int
    ) -> BottomCamera:
        """Return the camera of a level."""
        return draw_scenario(config, seed, trial, level).camera

    def first_camera(
        self, config: PatternsConfiguration, *, seed: int, trial: int, level: int
    ) -> BottomCamera:
        """Return the camera of a level: no image is special."""
        return self.camera(config, seed=seed, trial=trial, level=level)

    def labelled_scene(
        self, config: PatternsConfiguration, number: int, *, seed: int, images: int
    ) -> Iterator[LabelledImage]:
        """Yield the first images of a scene to train with."""
        yield from labelled_scene(config, number, seed=seed, images=images)

    def metrics(self, config: PatternsConfiguration, level: int, rows: Rows) -> dict[str, Any]:
        """Return the metrics of a level with its optical depth."""
        position = {"level": level, "optical_depth": config.optical_depths[level]}
        return position | level_metrics(
            rows, image_period_s=config.control_period_s, focal_px=OPTICS.focal_px
        )

    def trial_score(
        self, config: PatternsConfiguration, levels: Sequence[Mapping[str, Any]]
    ) -> TrialScore:
        """Return the area under average precision over the optical depth."""
        depths = [float(level["optical_depth"]) for level in levels]
        score = area(depths, [0.01 * float(level[AP.name]) for level in levels])
        return TrialScore(
            score=score,
            level_held=held_value(depths, [level["held"] for level in levels]),
            rankable=math.isfinite(score),
            reason="" if math.isfinite(score) else NO_OBJECT,
            overall=over_run(METRICS, levels),
        )


EXPERIMENT = Patterns()

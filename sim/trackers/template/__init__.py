"""The template tracker: Gauss-Newton alignment of a textured plane."""

from seamark.sim.trackers.declaration import Option, TrackerDeclaration, number_option
from seamark.sim.trackers.options import (
    CRITERION,
    MAX_JUMP,
    METHOD,
    PREDICT_MOTION,
    PYRAMID_LEVELS,
    SAMPLING_PX,
    SEARCH_PX,
    TEMPLATE_MARGIN_PX,
    WARP,
)

TRACKER = TrackerDeclaration(
    label="Template tracker (ESM family)",
    path="seamark.sim.trackers.template.tracker:TemplateTracker",
    options=(
        WARP,
        CRITERION,
        METHOD,
        PYRAMID_LEVELS,
        number_option(
            "coarse_iterations",
            6,
            low=0,
            high=100,
            title="Iterations on coarse pyramid levels",
            help="Maximum on each pyramid level but the finest.",
        ),
        number_option(
            "fine_iterations",
            5,
            low=1,
            high=100,
            title="Iterations on the finest pyramid level",
            help="Maximum on the full-resolution image.",
        ),
        number_option(
            "stop_px",
            0.5,
            low=0.0001,
            high=2,
            title="Convergence threshold",
            help="The iteration stops once a step moves every corner by less than this; with "
            "ssd and mi, by less than a fifth of it.",
            unit="px",
        ),
        SAMPLING_PX,
        TEMPLATE_MARGIN_PX,
        PREDICT_MOTION,
        SEARCH_PX,
        number_option(
            "reacquire_px",
            0,
            low=0,
            high=400,
            title="Re-acquisition radius",
            help="How far away a lost target is searched for, at most; the radius grows with each "
            "image. 0: no search.",
            unit="px",
        ),
        Option(
            name="smoothing",
            default="patch",
            title="Smoothing",
            help="What the 3x3 binomial filter is applied to. Interpolation is more accurate "
            "between smooth pixels.",
            choices={"patch": "The sampled template", "image": "The image before sampling"},
            advanced=True,
        ),
        Option(
            name="second_search",
            default=False,
            title="Second search",
            help="Whether a doubtful result is searched for again, starting from coarser pyramid "
            "levels.",
            advanced=True,
        ),
        MAX_JUMP,
    ),
)

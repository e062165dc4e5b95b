"""Options that several trackers share."""

from seamark.sim.trackers.declaration import Option, number_option

WARPS = {
    "translation": "Translation (2 parameters)",
    "rt": "Rotation and translation (3)",
    "srt": "Scale, rotation and translation (4)",
    "affine": "Affine (6)",
    "homography": "Homography (8)",
}
CRITERIA = {
    "zncc": "Zero-mean normalised cross-correlation",
    "ssd": "Sum of squared differences",
    "mi": "Mutual information",
}
METHODS = {
    "esm": "Efficient second-order minimisation",
    "inverse_compositional": "Inverse compositional",
    "forward_additional": "Forward additional",
    "forward_compositional": "Forward compositional",
}

WARP = Option(
    name="warp",
    default="homography",
    title="Warp",
    help="Which motions of the target in the image the tracker can follow.",
    choices=WARPS,
)
CRITERION = Option(
    name="criterion",
    default="zncc",
    title="Similarity",
    help="How the tracker compares images.",
    choices=CRITERIA,
)
METHOD = Option(
    name="method",
    default="esm",
    title="Method",
    help="The optimisation method.",
    choices=METHODS,
)
PYRAMID_LEVELS = number_option(
    "pyramid_levels",
    2,
    low=1,
    high=4,
    title="Pyramid levels",
    help="Maximum number of resolutions, each half the one before; more can follow faster motion.",
)
SAMPLING_PX = number_option(
    "sampling_px",
    1.0,
    low=1,
    high=4,
    title="Sampling",
    help="Distance between the template's pixels in the first image.",
    unit="px",
)
TEMPLATE_MARGIN_PX = number_option(
    "template_margin_px",
    -3,
    low=-3,
    high=40,
    title="Template margin",
    help="How far the template extends beyond the target; an untextured target needs its edges.",
    unit="px",
)
PREDICT_MOTION = Option(
    name="predict_motion",
    default=True,
    title="Predict the motion",
    help="Whether the search starts where the target would be at constant velocity.",
    advanced=True,
)
SEARCH_PX = number_option(
    "search_px",
    20,
    low=4,
    high=200,
    title="Search margin",
    help="Maximum distance from the last position at which the target is searched.",
    unit="px",
)
LARGEST_JUMP = 1.0 / 3.0  # E: of the target's longer side
MAX_JUMP = number_option(
    "max_jump",
    LARGEST_JUMP,
    low=0.1,
    high=10,
    title="Largest jump",
    help="If a corner moves farther from one image to the next, the target counts as lost; in "
    "multiples of the target's longer side.",
)

"""Settings of the noise of a camera and of the light that is drawn, which benchmarks share."""

from typing import Any

from seamark.sim.settings.setting import setting


def camera_noise_setting(*, group: str) -> Any:  # as setting itself
    """Return the setting of the read noise."""
    return setting(
        1.2,
        title="Camera noise",
        help="Standard deviation of the read noise, before the gain that makes up for the light.",
        group=group,
        role="scenario",
        unit="grey",
        low=0.8,
        high=16,
        tag="E",
        source="UWSim's 0.005 of full scale is 1.3 grey levels",
        advanced=True,
    )


def light_setting(*, group: str, of: str) -> Any:  # likewise
    """Return the setting of how much less light there may be; `of` is what it is drawn for."""
    return setting(
        0.5,
        title="Light variation",
        help=f"A {of} has up to this many stops less light: the camera's gain makes up for it and "
        "amplifies the noise.",
        group=group,
        role="scenario",
        unit="stops",
        low=0,
        high=3,
        tag="E",
        source="what an hour changes on a bright day",
        advanced=True,
    )

"""Attenuation and veil of the water, and the noise of the camera.

`beer`:  L = (J - B) exp(-c R) + B with the slant range R; c is the beam attenuation, not Kd:
         along a line of sight contrast decays with c (Duntley 1963).
`uwsim`: L = (J - B) exp(-(rho Z)^2) + B with the depth Z along the optical axis, as UWSim's fog.
Channels are in the order red (600 nm), green (550 nm), blue (450 nm). The grey image that
trackers get is the green channel.
"""

from dataclasses import dataclass
from typing import Self

Channels = tuple[float, float, float]

LAWS = {"beer": "Beer-Lambert attenuation", "uwsim": "UWSim fog"}

# [1/m] Beam attenuation c at 600, 550 and 450 nm.
# S: IB to 5C measured by Williamson & Hollins 2022; I, 7C and 9C by Solonenko & Mobley 2015, whose
# other rows disagree with the measured ones and are not used.
JERLOV: dict[str, Channels] = {
    "I": (0.229, 0.064, 0.022),
    "IB": (0.345, 0.188, 0.176),
    "II": (0.401, 0.249, 0.257),
    "III": (0.519, 0.375, 0.421),
    "1C": (0.664, 0.526, 0.603),
    "3C": (0.895, 0.772, 0.886),
    "5C": (1.445, 1.349, 1.583),
    "7C": (2.33, 2.55, 3.84),
    "9C": (3.08, 3.47, 5.33),
}
AMBIENT_VEIL: Channels = (0.10, 0.32, 0.33)  # E: scattered daylight, share of full scale
UWSIM_VEIL: Channels = (0.0, 0.05, 0.3)  # S: UWSim's fog colour
MIN_SIGMA_GREY = 0.8  # below it 8-bit rounding, not the water, would decide which tracker fails


@dataclass(frozen=True, slots=True, kw_only=True)
class Water:
    """Law, attenuation per channel, veil per channel and noise of one level."""

    law: str = "beer"
    attenuation: Channels = JERLOV["IB"]  # c [1/m] for beer, rho [1/m] for uwsim
    veil: Channels = AMBIENT_VEIL  # share of full scale
    read_sigma_grey: float = 1.2  # E: usual for an 8-bit machine-vision camera
    shot_gain: float = 0.01  # [grey] variance per grey of signal, E

    def __post_init__(self) -> None:
        """Refuse impossible water."""
        if self.law not in LAWS:
            raise ValueError(f"water law {self.law!r} is none of {', '.join(LAWS)}")
        if not all(0 <= c <= 100 for c in self.attenuation):
            raise ValueError(f"attenuation {self.attenuation} is not within 0..100 1/m")
        if not all(0 <= b <= 1 for b in self.veil):
            raise ValueError(f"veil {self.veil} is not within 0..1")
        if not MIN_SIGMA_GREY <= self.read_sigma_grey <= 64:
            raise ValueError(
                f"read_sigma_grey is {self.read_sigma_grey}; it must be {MIN_SIGMA_GREY}..64 grey"
            )
        if not 0 <= self.shot_gain <= 1:
            raise ValueError(f"shot_gain {self.shot_gain} is not within 0..1")

    @classmethod
    def of_type(cls, jerlov: str) -> Self:
        """Return natural water of one of Jerlov's types, from `I` (ocean) to `9C` (harbour)."""
        return cls(attenuation=JERLOV[jerlov])

    @classmethod
    def grey(cls, attenuation: float, *, law: str = "beer") -> Self:
        """Return water that attenuates all colours alike: the axis of a grid over turbidity."""
        veil = UWSIM_VEIL if law == "uwsim" else AMBIENT_VEIL
        return cls(law=law, attenuation=(attenuation,) * 3, veil=veil)

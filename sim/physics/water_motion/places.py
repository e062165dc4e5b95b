"""What is known of currents at kinds of places: profiles and turbulence.

Tags: S sourced, D derived from sourced, E our estimate. Kim and Hong: J. Korean Soc. Fish. Technol.
50(4) 435 (2014), near the bottom of a coastal trench. Thomson: Thomson et al., IEEE J. Oceanic Eng.
37(3) (2012), tidal channels. TurbSim: NREL's model TIDAL, standard deviations of 4.5, 2.25 and 0.9
squared friction velocities, to the half, near the bottom. Uldolmok: J. Korean Soc. Coastal Ocean
Eng. 29(6) (2017).
The tide itself changes a current by less than 1 % a minute, which is left out.
"""

from dataclasses import dataclass

ACROSS, UPRIGHT = 0.71, 0.45  # D: TurbSim, of the deviation along the current
LENGTH_PER_HEIGHT = 2.4  # E: eddies a few times as long as they are high above the bottom


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """A kind of place: the turbulence along a current U is (intensity² U² + floor²)^(1/2)."""

    title: str
    exponent: float  # of the profile, see `current.Shear`
    intensity: float  # of a strong current
    floor_m_s: float  # [m/s] standard deviation that a weak current has all the same
    sources: dict[str, str]  # of each number: tag and source


PLACES = {
    "harbour": Place(
        title="Harbour",
        exponent=0.2,
        intensity=0.15,
        floor_m_s=0.02,
        sources={
            "exponent": "E: rougher than a plain bottom",
            "intensity": "E: eddies behind quays and piles, above the 0.11 of a plain bottom",
            "floor_m_s": "E: what wind and vessels leave in sheltered water",
        },
    ),
    "ria": Place(
        title="Ria",
        exponent=1.0 / 7.0,
        intensity=0.05,
        floor_m_s=0.098,
        sources={
            "exponent": "S: DNV-RP-C205 (2010) 4.1.4: tidal current",
            "intensity": "D: with the floor the 50 % at 0.2 m/s of Kim and Hong, and 12 % at 0.9",
            "floor_m_s": "D: same",
        },
    ),
    "channel": Place(
        title="Tidal channel",
        exponent=0.1,
        intensity=0.1,
        floor_m_s=0.03,
        sources={
            "exponent": "S: Uldolmok, 1/10.75 on the flood and 1/9.3 on the ebb",
            "intensity": "S: Thomson",
            "floor_m_s": "E",
        },
    ),
    "shelf": Place(
        title="Open shelf",
        exponent=1.0 / 7.0,
        intensity=0.11,
        floor_m_s=0.01,
        sources={
            "exponent": "S: DNV-RP-C205 (2010) 4.1.4: tidal current",
            "intensity": "D: TurbSim, 2.1 friction velocities, each 0.05 U for a drag of 0.0025",
            "floor_m_s": "E: no wind and vessels near the bottom; waves are a setting of their own",
        },
    ),
}

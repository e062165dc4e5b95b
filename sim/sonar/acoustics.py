"""Sound in sea water and on surfaces: absorption, noise, backscatter.

Levels in dB, intensities relative to that of the source at 1 m.
"""

import math

from seamark.sim.numerics.libm import exp, log

SOUND_M_S = 1500.0  # S: sea water, Urick 1983, ch. 5
TEMPERATURE_C, SALINITY, DEPTH_M, ACIDITY_PH = 12.0, 35.0, 15.0, 8.0  # E: inshore
# Lambert's rule: the backscattering strength of a surface is 10 log10(mu sin^2(grazing angle))
# (Urick 1983, ch. 8). On sand it holds down to grazing angles of 2 degrees, and mu grows with the
# frequency between its first and its 1.5th power (Boehme et al. 1985, JASA 77(3), 962-974).
SAND_DB = -20.0  # 10 log10 mu; E: above the -27 dB of deep-sea beds at 1 kHz (Mackenzie 1961)
HARD_DB = -10.0  # E: of concrete and steel that is rough at the scale of the wavelength, 2 mm
_LN_10 = 2.302585092994046


def power_of_ten(exponent: float) -> float:
    """Return 10**x, the same on every processor."""
    return exp(_LN_10 * exponent)


def absorption_db_m(frequency_khz: float) -> float:
    """Return the absorption of sound in sea water [dB/m], from 0.4 to 1000 kHz.

    Francois & Garrison 1982, JASA 72(3), 896-907 and 72(6), 1879-1890, for at most 20 degrees C.
    """
    t, kelvin, squared = TEMPERATURE_C, TEMPERATURE_C + 273.0, frequency_khz * frequency_khz
    boron = 8.86 / SOUND_M_S * power_of_ten(0.78 * ACIDITY_PH - 5.0)
    boron_khz = 2.8 * math.sqrt(SALINITY / 35.0) * power_of_ten(4.0 - 1245.0 / kelvin)
    sulphate = 21.44 * SALINITY / SOUND_M_S * (1.0 + 0.025 * t)
    sulphate *= 1.0 - 1.37e-4 * DEPTH_M + 6.2e-9 * DEPTH_M * DEPTH_M
    sulphate_khz = 8.17 * power_of_ten(8.0 - 1990.0 / kelvin) / (1.0 + 0.0018 * (SALINITY - 35.0))
    water = 4.937e-4 + t * (-2.59e-5 + t * (9.11e-7 - 1.50e-8 * t))
    water *= 1.0 - 3.83e-5 * DEPTH_M + 4.9e-10 * DEPTH_M * DEPTH_M
    relaxed = boron * boron_khz / (squared + boron_khz * boron_khz)
    relaxed += sulphate * sulphate_khz / (squared + sulphate_khz * sulphate_khz)
    return 1e-3 * squared * (relaxed + water)


def thermal_noise_db(frequency_khz: float, bandwidth_hz: float) -> float:
    """Return the level of the water's thermal noise [dB re 1 µPa] in a band.

    Its density is -15 + 20 log10(frequency in kHz) dB re 1 µPa²/Hz (Mellen 1952; Urick 1983, 7);
    above some 100 kHz it exceeds the noise of the sea.
    """
    return -15.0 + (20.0 * log(frequency_khz) + 10.0 * log(bandwidth_hz)) / _LN_10

"""The sonar: an image is a pure function of where things are, noise seed and frame number."""

import math

import numpy as np
from numpy.typing import NDArray

from seamark.sim.camera.bodies import Bodies, Paints, Placed
from seamark.sim.camera.camera import noise_bank
from seamark.sim.camera.instant import Mount
from seamark.sim.camera.lighting import Lighting
from seamark.sim.multibody.assembly import Frame
from seamark.sim.numerics.arrays import Array
from seamark.sim.numerics.compilation import SameTypes
from seamark.sim.numerics.libm import sincos
from seamark.sim.numerics.simd import WIDTH
from seamark.sim.sonar import acoustics
from seamark.sim.sonar.device import (
    APERTURE_RAD,
    BEAM_RAD,
    DIRECTIVITY_DB,
    FREQUENCY_KHZ,
    MOUNT_M,
    RAYS,
    SOURCE_DB,
    Device,
)
from seamark.sim.sonar.echoes import COLUMNS, Fan, Waters, ping
from seamark.sim.sonar.seabed_strength import TILE, strength_tile
from seamark.sim.sonar.speckle import Fields, Receiver, receive

# [dB] E: target strength of what is white. The gain over time undoes spreading and absorption of
# the echo of a small target, 40 log10 r + 2 alpha r (Urick 1983, ch. 2), so that a grey level is a
# target strength at any range: WHITE_DB + 20 log10(level / 255).
WHITE_DB = -32.0
LEAST_PATTERN = 0.01  # of the amplitude; what a beam receives from farther aside is left out
_DARK = (0.0, 0.0, 0.0)


def mounted(device: Device, vehicle: str) -> Frame:
    """Return where the sonar is on a link: ahead, looking down by its tilt."""
    sine, cosine = sincos(device.tilt_rad)
    turn = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
    return Frame(vehicle, np.array(MOUNT_M), turn)


class Sonar:
    """Makes the images of an imaging sonar that looks along the x axis of `mount`.

    Parameters
    ----------
    bodies : Bodies
        What it sees besides the seabed, which is flat.
    strengths : (n,)
        Lambert's mu of each of them, see `acoustics`.
    rays : int
        Slices of each column of rays.
    """

    def __init__(
        self,
        device: Device,
        bodies: Bodies,
        strengths: Array,
        *,
        mount: Frame,
        seabed_m: float,
        noise_seed: int,
        rays: int = RAYS,
    ) -> None:
        self.device, self.bodies = device, bodies
        self._seed = noise_seed & 0x7FFFFFFFFFFFFFFF  # int64, so one compilation
        self._mount = Mount(
            bodies.number(mount.link),
            np.array(mount.point, dtype=np.float64),
            np.array(mount.turn, dtype=np.float64),
        )
        count = len(bodies.shapes.kind)
        paints = Paints(
            np.array(strengths, dtype=np.float64).reshape(count),
            np.zeros(1, np.int32),
            np.zeros((count, 1, 3), np.int32),
        )
        self._waters = Waters(
            shapes=bodies.shapes,
            strengths=paints,
            seabed_m=float(seabed_m),
            sand=acoustics.power_of_ten(0.1 * acoustics.SAND_DB),
            tile=strength_tile(),
            # The bottom of no two levels is the same where a program has been.
            shift=(float(self._seed % TILE), float(self._seed // TILE % TILE)),
            bin_m=device.bin_m,
        )
        self._receiver = receiver_of(device)
        beyond = len(self._receiver.pattern) // 2
        self._fan = fan_of(device, beyond, rays=rays)
        beams = device.beams + 2 * beyond
        self._near = np.zeros((3, self._fan.y.shape[1]), np.float32)
        self._echoes = np.zeros((beams, device.bins), np.float32)
        self._fields = Fields(
            np.zeros((beams, device.bins), np.float32),
            np.zeros((beams, device.bins), np.float32),
            np.zeros(device.bins, np.int32),
        )
        self._bank = noise_bank(self._seed, device.bins)[None]
        links = len(bodies.links)
        self._placed = np.zeros((links, 3, 3)), np.zeros((links, 3)), np.zeros((links, 6))
        self._ping, self._receive = SameTypes(ping), SameTypes(receive)

    def image(self, placed: Placed, frame: int) -> NDArray[np.uint8]:
        """Return a new image (bins, beams): the one that programs get."""
        image = np.empty((self.device.bins, self.device.beams), np.uint8)
        key = (self._seed, frame)
        self._echo(placed)
        self._receive.call(self._echoes, self._receiver, self._bank, key, self._fields, image)
        return image

    def echoes(self, placed: Placed) -> NDArray[np.float32]:
        """Return what returns of each beam from each range, (beams, bins), relative to the ping.

        Before losses on the way, beam pattern, speckle and noise.
        """
        self._echo(placed)
        beyond = len(self._receiver.pattern) // 2
        return self._echoes[beyond : beyond + self.device.beams].copy()

    def _echo(self, placed: Placed) -> None:
        for mine, given in zip(self._placed, placed, strict=True):
            mine[:] = given
        self._ping.call(
            *(self._placed, self._mount, self._fan, self._waters, _NO_LIGHT),
            *(self._near, self._echoes),
        )


_NO_LIGHT = Lighting(0.0, 0.0, 1.0, _DARK, _DARK, _DARK, _DARK, 0.0, 0.0, False)


def fan_of(device: Device, beyond: int, *, rays: int) -> Fan:
    """Return the rays of all beams, and of so many beyond both sides of the sector."""
    edges = (rays + WIDTH) // WIDTH * WIDTH
    step = APERTURE_RAD / rays
    elevations = [min(i, rays) * step - 0.5 * APERTURE_RAD for i in range(edges)]
    tilts = [sincos(elevation) for elevation in elevations]
    solid = [
        device.spacing_rad / COLUMNS * step * sincos(middle)[1] * _vertical_pattern(middle)
        for middle in (elevation + 0.5 * step for elevation in elevations[:rays])
    ]
    x, y, length = [], [], []
    for column in range(-beyond * COLUMNS, (device.beams + beyond) * COLUMNS):
        sine, cosine = sincos(device.azimuth_rad((column + 0.5) / COLUMNS - 0.5))
        x.append(sine / cosine)
        y.append([up / (level * cosine) for up, level in tilts])
        length.append([1.0 / (level * cosine) for _up, level in tilts])
    return Fan(
        np.array(x),
        np.array(y, np.float32),
        np.array(length, np.float32),
        np.array([solid], np.float32),
    )


def _vertical_pattern(elevation_rad: float) -> float:
    """Return the share of the intensity, out and back: half of it each way at the edge."""
    share = 2.0 * elevation_rad / APERTURE_RAD
    return acoustics.power_of_ten(-2.0 * _HALF_OF_TEN * share * share)


_HALF_OF_TEN = 0.3010299956639812  # log10 of 2


def pattern_of(device: Device) -> NDArray[np.float32]:
    """Return the amplitude that a beam receives of its neighbours, its own in the middle.

    E: that of a shaded array, without side lobes: half of the intensity at half of its width.
    """
    taps: list[float] = []
    while True:
        share = 2.0 * len(taps) * device.spacing_rad / BEAM_RAD
        tap = acoustics.power_of_ten(-0.5 * _HALF_OF_TEN * share * share)
        if tap < LEAST_PATTERN:
            break
        taps.append(tap)
    return np.array([*reversed(taps[1:]), *taps], np.float32)


def receiver_of(device: Device) -> Receiver:
    """Return what turns echoes into an image."""
    absorption = acoustics.absorption_db_m(FREQUENCY_KHZ)
    loss, gain = [], []
    for j in range(device.bins):
        away = (j + 0.5) * device.bin_m
        share = acoustics.power_of_ten(-0.2 * absorption * away)
        loss.append(share / (away * away))
        white = acoustics.power_of_ten(0.1 * WHITE_DB) * share
        gain.append(255.0 * away * away / math.sqrt(white))
    pattern = pattern_of(device)
    bandwidth = 0.5 * acoustics.SOUND_M_S / device.bin_m
    noise_db = acoustics.thermal_noise_db(FREQUENCY_KHZ, bandwidth) - DIRECTIVITY_DB - SOURCE_DB
    passed = sum(tap * tap for tap in pattern.tolist())
    return Receiver(
        pattern,
        np.array([loss], np.float32),
        acoustics.power_of_ten(0.1 * noise_db) / passed,
        np.array([gain], np.float32),
    )

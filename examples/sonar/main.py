"""Hold station before a weight on the seabed by an imaging sonar alone.

    seamark run track-v1 --controller examples/sonar/main.py --set sonar=forward --set levels=0.2

A level of track-v1 begins above the weight. The program backs off until the weight is in the image,
finds its echo, and then keeps it where it is: STANDOFF_M away and straight ahead, in the current.
It uses neither the acoustic fixes nor the route.
"""

import math

import numpy as np

STANDOFF_M = 13.0  # slant range at which the weight is held
BACK_M_S, BACK_M = -0.5, 12.5  # how fast and how far to back off
SECTOR = math.radians(120.0)
CELL = (3, 5)  # bins and beams of an echo: what speckle is averaged over
NEAR = (14, 16)  # bins and beams around the last echo in which the next one is looked for
KP, KI = 0.35, 0.03  # of the position [1/s, 1/s²]
MOST_M_S = 0.6


def smoothed(image):
    """Return the mean intensity over CELL, by running sums."""
    intensity = image.astype(np.float32) ** 2
    for axis, size in enumerate(CELL):
        sums = np.cumsum(intensity, axis=axis, dtype=np.float64)
        padded = np.insert(sums, 0, 0.0, axis=axis)
        ahead, behind = np.arange(size, padded.shape[axis]), np.arange(padded.shape[axis] - size)
        intensity = (padded.take(ahead, axis=axis) - padded.take(behind, axis=axis)) / size
    return intensity


class Controller:
    """Backs off, finds the weight, holds it."""

    def __init__(self, config):
        self.bin_m = config["sonar_range_m"] / 400.0

    def reset(self, level):
        self.backed_m = 0.0
        self.cell = None  # of the echo: row and column of its middle
        self.sum = [0.0, 0.0]
        self.seen_at = -1.0

    def step(self, observation):
        if self.backed_m < BACK_M:
            self.backed_m -= min(observation.velocity[0], 0.0) * observation.dt
            return [BACK_M_S, 0.0, 0.0, 0.0]
        if observation.image_t != self.seen_at:
            self.seen_at = observation.image_t
            self.look(observation.images["sonar"])
        return [*self.hold(observation.dt), 0.0, 0.0]

    def look(self, image):
        """Find the strongest echo: anywhere at first, then where it was."""
        strength = smoothed(image)
        top, left = (0, 0)
        if self.cell is not None:
            row, column = (int(at) for at in self.cell)
            top, left = max(row - NEAR[0], 0), max(column - NEAR[1], 0)
            strength = strength[top : row + NEAR[0], left : column + NEAR[1]]
        row, column = np.unravel_index(int(strength.argmax()), strength.shape)
        self.cell = (top + row + CELL[0] // 2, left + column + CELL[1] // 2)

    def place(self):
        """Return how far ahead and to starboard the echo is [m], in the sonar's plane."""
        row, column = self.cell
        away = (row + 0.5) * self.bin_m
        azimuth = ((column + 0.5) / 256.0 - 0.5) * SECTOR
        return away * math.cos(azimuth), away * math.sin(azimuth)

    def hold(self, dt):
        """Return surge and sway that bring the echo to where it is wanted."""
        ahead, aside = self.place()
        commands = []
        for axis, error in enumerate((ahead - STANDOFF_M, aside)):
            command = KP * error + self.sum[axis]
            if abs(command) < MOST_M_S:
                self.sum[axis] += KI * error * dt
            commands.append(min(max(command, -MOST_M_S), MOST_M_S))
        return commands

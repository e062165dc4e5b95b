"""The controller that train_station_keeping.py trains; the gains are those of the published PI."""

import numpy as np

GAINS = {"kp": 0.5, "ki": 0.02, "kd": 0.0, "kp_yaw": 0.0, "kd_yaw": 0.0}
LONGEST_INTEGRAL = 10.0  # m s


class Controller:
    """Error, its integral and velocity on surge and sway; heading north."""

    def __init__(self, config):
        self.integral = np.zeros(2)

    def reset(self, level):
        self.integral = np.zeros(2)

    def step(self, observation):
        error = observation.error[:2]
        self.integral = self.integral + error * observation.dt
        self.integral = np.clip(self.integral, -LONGEST_INTEGRAL, LONGEST_INTEGRAL)
        push = GAINS["kp"] * error + GAINS["ki"] * self.integral
        surge, sway = push - GAINS["kd"] * observation.velocity[:2]
        turn = GAINS["kp_yaw"] * observation.attitude[2] + GAINS["kd_yaw"] * observation.rates[2]
        return surge, sway, 0.0, -turn

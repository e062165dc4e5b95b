"""Moves an arm, as a starting point: keeps the vehicle above its target, the hand open below it."""

# [rad] slew, upper arm, forearm, wrist and jaws of the arm-5e-like: the tool points down
POSTURE = (0.0, 0.45, 0.6, 0.0, 0.6)
FASTEST = 0.3  # [rad/s] that all of its motors reach


class Controller:
    def __init__(self, config):
        self.gain = 0.5  # 1/s

    def step(self, observation):
        # called 20 times per simulated second; the speeds of the joints follow the vehicle's four
        forward, starboard, _down = self.gain * observation.error  # m/s
        wanted = [2.0 * (goal - now) for goal, now in zip(POSTURE, observation.joints, strict=True)]
        speeds = [min(max(speed, -FASTEST), FASTEST) for speed in wanted]
        return [forward, starboard, 0.0, 0.0, *speeds]

"""A PI position controller as a starting point."""


class Controller:
    def __init__(self, config):
        # config: the configuration of the run, without the seed of the trial
        self.kp = config.get("kp", 0.5)
        self.ki = config.get("ki", 0.02)
        self.limit = 0.6  # m/s

    def reset(self, level):
        # called at the start of each level, when the vehicle is moved back
        self.integral = [0.0, 0.0, 0.0]

    def step(self, observation):
        # called 20 times per simulated second
        if not observation.target_visible:
            return [0.0, 0.0, 0.0, 0.0]
        command = []
        for axis, error in enumerate(observation.error):  # m: forward, starboard, down
            self.integral[axis] += error * observation.dt
            speed = self.kp * error + self.ki * self.integral[axis]
            command.append(max(-self.limit, min(self.limit, speed)))
        return [*command, 0.0]  # surge, sway, heave m/s and yaw rate rad/s

"""A PI position controller as a starting point: the law of the built-in PI."""


class Controller:
    def __init__(self, config):
        # config: the configuration of the run, without the seed of the trial
        self.kp = config["kp"]
        self.ki = config["ki"]
        self.limit = config["reference_limit_m_s"]
        self.axes = 3 if config["control_heave"] else 2
        self.integral = [0.0, 0.0, 0.0]  # m/s

    def reset(self, level):
        # called at the start of each level, when the vehicle is moved back
        self.integral = [0.0, 0.0, 0.0]

    def step(self, observation):
        # called 20 times per simulated second; vectors are read-only NumPy arrays
        command = [0.0, 0.0, 0.0, 0.0]  # surge, sway, heave m/s and yaw rate rad/s
        for axis in range(self.axes):
            error = observation.error[axis]  # m: forward, starboard, down
            change = self.ki * error * observation.dt if observation.target_visible else 0.0
            wanted = self.kp * error + self.integral[axis] + change
            command[axis] = min(max(wanted, -self.limit), self.limit)
            # anti-windup: at the limit the integral may only move back inside
            if command[axis] == wanted or (wanted - command[axis]) * change < 0.0:
                self.integral[axis] += change
        return command

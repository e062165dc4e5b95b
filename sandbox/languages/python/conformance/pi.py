"""The built-in PI once more, as an upload."""


class Controller:
    def __init__(self, config):
        self.kp = config["kp"]
        self.ki = config["ki"]
        self.limit = config["reference_limit_m_s"]
        self.axes = 3 if config["control_heave"] else 2
        self.integral = [0.0, 0.0, 0.0]

    def reset(self, level):
        self.integral = [0.0, 0.0, 0.0]

    def step(self, observation):
        command = [0.0, 0.0, 0.0, 0.0]
        for axis in range(self.axes):
            error = observation.error[axis]
            change = self.ki * error * observation.dt if observation.target_visible else 0.0
            wanted = self.kp * error + self.integral[axis] + change
            command[axis] = min(max(wanted, -self.limit), self.limit)
            if command[axis] == wanted or (wanted - command[axis]) * change < 0.0:
                self.integral[axis] += change
        return command

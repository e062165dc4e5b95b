"""The built-in PI once more, for PythonFMU to export: the same operations in the same order."""

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class PI(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.kp = self.ki = self.reference_limit_m_s = 1.0
        self.control_heave = self.target_visible = False
        self.error_x = self.error_y = self.error_z = 0.0
        self.surge = self.sway = self.heave = 0.0
        self.integral = [0.0, 0.0, 0.0]
        kept = {"causality": Fmi2Causality.parameter, "variability": Fmi2Variability.tunable}
        for name in ("kp", "ki", "reference_limit_m_s"):
            self.register_variable(Real(name, **kept))
        self.register_variable(Boolean("control_heave", **kept))
        for name in ("error_x", "error_y", "error_z"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        self.register_variable(Boolean("target_visible", causality=Fmi2Causality.input))
        for name in ("surge", "sway", "heave"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        errors = (self.error_x, self.error_y, self.error_z)
        command = [0.0, 0.0, 0.0]
        for axis in range(3 if self.control_heave else 2):
            change = self.ki * errors[axis] * step_size if self.target_visible else 0.0
            wanted = self.kp * errors[axis] + self.integral[axis] + change
            limit = self.reference_limit_m_s
            command[axis] = min(max(wanted, -limit), limit)
            if command[axis] == wanted or (wanted - command[axis]) * change < 0.0:
                self.integral[axis] += change
        self.surge, self.sway, self.heave = command
        return True

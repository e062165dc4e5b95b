"""Charts of a vehicle's arm."""

from seamark.sim.benchmarks.benchmark import Chart
from seamark.sim.recording.telemetry import ARM_FEELERS, ARM_JOINTS, numbered

ARM_CHARTS = (
    Chart("Joints", "rad", numbered("joint", ARM_JOINTS)),
    Chart("Joint speed commands", "rad/s", numbered("joint_ref", ARM_JOINTS)),
    Chart("Joint torques", "N m", numbered("joint_effort", ARM_JOINTS)),
    Chart("Force at the wrist", "N", ("wrist_fx", "wrist_fy", "wrist_fz")),
    Chart("Touch of the hand", "N", (*numbered("touch", ARM_FEELERS), "arm_peak_n")),
)

"""Model predictive control of a vehicle's position: a horizon of moves within thrusters' limits.

`horizon` predicts and weighs, `qp` solves; who uses them estimates the state and the disturbance.
"""

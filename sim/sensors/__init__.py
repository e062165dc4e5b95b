"""Sensors of the vehicle's own motion: DVL, AHRS, depth gauge, altimeter."""

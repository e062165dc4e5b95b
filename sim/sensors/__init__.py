"""What the vehicle measures of its own motion: DVL, AHRS, depth gauge, altimeter."""

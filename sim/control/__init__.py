"""From the target's position in the image to thruster commands."""

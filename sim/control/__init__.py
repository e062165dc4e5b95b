"""From the target's place in the image to thruster commands."""

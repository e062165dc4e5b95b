"""recover-v1: lift a box from the seabed with an arm."""

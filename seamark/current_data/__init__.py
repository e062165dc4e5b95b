"""Measured and computed currents: read from others' files, checked, and made records of."""

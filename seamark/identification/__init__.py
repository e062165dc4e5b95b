"""Fits drag and added mass of a vehicle to a log, and writes the vehicle's file."""

"""The form of a new run: settings, program, parameters, sweep; the first controller."""

"""The commands of `seamark`, one file per group."""

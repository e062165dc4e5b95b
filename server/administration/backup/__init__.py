"""Backups: one file with the database, the programs and the data of runs; and what restores it."""

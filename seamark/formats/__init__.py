"""Runs as files that other programs read: Parquet, NPZ, MAT, MCAP, and an archive to run again.

The same code writes them for the service and for results on this machine. Every writer needs a
bounded part of the rows at a time, whatever the length of the run, and the same run always gives
the same bytes: no file has the time at which it was made.
"""

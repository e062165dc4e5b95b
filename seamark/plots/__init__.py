"""Plots of results: in a terminal and as pictures, of local folders and of runs on a server."""

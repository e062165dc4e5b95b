"""Plots as shapes of a page: axes, points, labels that do not overlap."""

"""Competitions: what is asked, rounds, teams and their entries."""

"""Competitions, their boards, teams and entries."""

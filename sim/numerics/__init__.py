"""Arithmetic that gives the same bits on every x86-64 processor."""

"""Competitions without a server: keys and seeds of rounds, ranks of a final, audit of it all."""

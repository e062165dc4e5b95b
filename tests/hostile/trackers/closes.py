"""Closes the connection."""

import os


def attack(image):
    os.close(protocol())

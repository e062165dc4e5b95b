"""Reads memory that is not there."""

import ctypes


def attack(image):
    ctypes.string_at(0)

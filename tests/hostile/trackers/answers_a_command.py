"""Answers with a command where corners are wanted."""

import struct


def attack(image):
    send(b"c", struct.pack("<4d", 0, 0, 0, 0))

"""Answers the questions to come."""

import struct


def attack(image):
    if image[0, 0] >= 0:
        send(b"t", struct.pack("<8d", *[1.0] * 8), range(4, 12))

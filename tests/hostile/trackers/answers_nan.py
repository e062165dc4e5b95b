"""Sends corners that are no numbers past the runner."""

import struct


def attack(image):
    send(b"t", struct.pack("<8d", *[float("nan")] * 8))

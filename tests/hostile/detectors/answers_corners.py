"""Answers as a tracker does."""


def attack(image):
    send(b"t", struct.pack("<8d", *[1.0] * 8), THIS)

"""Sends a label of 60 000 bytes past the runner, nearly all that a message takes."""


def attack(image):
    send(b"d", struct.pack("<I", 1) + packed(b"x" * 60_000), THIS)

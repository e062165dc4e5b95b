"""Sends a frame beyond all sizes."""


def attack(image):
    send(b"t", bytes(100_000))

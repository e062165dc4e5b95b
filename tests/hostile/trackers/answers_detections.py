"""Answers as a detector does."""


def attack(image):
    send(b"d", bytes(4))

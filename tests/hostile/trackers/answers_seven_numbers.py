"""Sends too few numbers past the runner."""


def attack(image):
    send(b"t", bytes(56))

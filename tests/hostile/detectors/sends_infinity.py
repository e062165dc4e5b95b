"""Sends a corner at infinity past the runner."""


def attack(image):
    far = packed(b"box", corners=[0.0] * 7 + [float("-inf")])
    send(b"d", struct.pack("<I", 1) + far, THIS)

"""Sends a label beyond the size of a message past the runner."""


def attack(image):
    send(b"d", struct.pack("<I", 1) + packed(b"x" * 65_535), THIS)

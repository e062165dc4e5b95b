"""Sends a label that is not UTF-8 past the runner."""


def attack(image):
    send(b"d", struct.pack("<I", 1) + packed(b"box\xff\xfe"), THIS)

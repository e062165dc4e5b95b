"""Sends answers without end past the runner."""


def attack(image):
    while True:
        send(b"d", struct.pack("<I", 0), THIS)

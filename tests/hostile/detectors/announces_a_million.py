"""Announces a million detections past the runner, and sends as many as a message takes."""


def attack(image):
    send(b"d", struct.pack("<I", 1_000_000) + 800 * packed(b"box"), THIS)

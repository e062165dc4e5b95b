"""Announces more detections than it sends."""


def attack(image):
    send(b"d", struct.pack("<I", 64) + packed(b"box"), THIS)

"""Sends corners that are no numbers past the runner."""


def attack(image):
    nothing = packed(b"box", corners=[float("nan")] * 8)
    send(b"d", struct.pack("<I", 1) + nothing, THIS)

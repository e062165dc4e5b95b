# Put between an attack in Python on the answers of a tracker or detector and its class.

import os
import struct


def protocol():
    for number in range(3, 256):
        try:
            os.fstat(number)
        except OSError:
            continue
        return number


def send(kind, body, sequences=range(1, 64)):
    for sequence in sequences:
        os.write(protocol(), struct.pack("<cB2xI", kind, 1, sequence) + body)

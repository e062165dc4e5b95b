"""Writes into the image by its address."""

import ctypes


def attack(image):
    ctypes.memset(image.ctypes.data, 7, 1)
    print("GOT the image")

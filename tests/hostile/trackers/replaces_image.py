"""Puts memory of its own in the place of the image: it fools nobody but itself."""

import ctypes

LIBC = ctypes.CDLL(None, use_errno=True)


def attack(image):
    page = image.ctypes.data & ~4095
    LIBC.mmap.restype = ctypes.c_void_p
    LIBC.mmap(ctypes.c_void_p(page), 4096, 3, 0x32, -1, 0)  # private, anonymous, fixed
    ctypes.memset(page, 7, 4096)

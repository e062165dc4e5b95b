"""Has the kernel make the image's memory writable."""

import ctypes

LIBC = ctypes.CDLL(None, use_errno=True)


def attack(image):
    page = image.ctypes.data & ~4095
    if LIBC.mprotect(ctypes.c_void_p(page), 4096, 3) == 0:
        print("GOT writable memory")
    for advice in (9, 8):  # MADV_REMOVE, MADV_FREE
        if LIBC.madvise(ctypes.c_void_p(page), 4096, advice) == 0:
            print("GOT the pages", advice)

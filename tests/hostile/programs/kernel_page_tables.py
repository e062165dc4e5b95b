"""Fills the memory of the kernel with page tables: it reads here and there in a huge mapping."""

import ctypes

MAP_PRIVATE, MAP_ANONYMOUS, MAP_NORESERVE = 2, 0x20, 0x4000
PROT_READ = 1
MADV_NOHUGEPAGE = 15
SIZE, APART = 1 << 40, 2 << 20  # [B]


class Controller:
    def __init__(self, config):
        libc = ctypes.CDLL(None, use_errno=True)
        libc.mmap.restype = ctypes.c_void_p
        flags = MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE
        start = libc.mmap(None, ctypes.c_size_t(SIZE), PROT_READ, flags, -1, 0)
        if start == ctypes.c_void_p(-1).value:
            raise MemoryError
        libc.madvise(ctypes.c_void_p(start), ctypes.c_size_t(SIZE), MADV_NOHUGEPAGE)
        for offset in range(0, SIZE, APART):
            ctypes.string_at(start + offset, 1)

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]

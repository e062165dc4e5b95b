"""Fills the memory that the kernel keeps for a box."""

import ctypes
import os
import socket
import time

HELD = ()
LIBC = ctypes.CDLL(None, use_errno=True)
MAP_PRIVATE, MAP_ANONYMOUS = 2, 0x20


def page_tables(observation):
    """Fills the memory of the kernel with page tables: it reads here and there in a huge mapping."""
    size, apart, no_reserve, no_huge_pages = 1 << 40, 2 << 20, 0x4000, 15
    LIBC.mmap.restype = ctypes.c_void_p
    flags = MAP_PRIVATE | MAP_ANONYMOUS | no_reserve
    start = LIBC.mmap(None, ctypes.c_size_t(size), 1, flags, -1, 0)
    if start == ctypes.c_void_p(-1).value:
        raise MemoryError
    LIBC.madvise(ctypes.c_void_p(start), ctypes.c_size_t(size), no_huge_pages)
    for offset in range(0, size, apart):
        ctypes.string_at(start + offset, 1)


def small_files(observation):
    """Fills the memory of the kernel with empty files, which take no space in /tmp."""
    for number in range(10_000_000):
        os.close(os.open(f"/tmp/{number}", os.O_CREAT))


def sockets(observation):
    """Fills the memory of the kernel with messages that nobody reads, in many processes."""
    for _ in range(12):
        if os.fork() == 0:
            break
    kept = []
    try:
        while True:
            pair = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
            kept.append(pair)
            for end in pair:
                end.setblocking(False)
                try:
                    while True:
                        end.send(b"x" * 32768)
                except BlockingIOError:
                    pass
    except OSError:
        time.sleep(600)

"""Takes what all have to share: memory, files, the log, the disk."""

import ctypes
import fcntl
import os
import sys
import time

HELD = PermissionError
LIBC = ctypes.CDLL(None, use_errno=True)
LIBRARY = "/usr/lib/x86_64-linux-gnu/libm.so.6"
MAP_PRIVATE, MAP_ANONYMOUS, MAP_HUGETLB = 2, 0x20, 0x40000


def caught(observation):
    """Sees MemoryError or is ended."""
    heap = []
    while True:
        try:
            heap.append(b"x" * (1 << 24))
        except MemoryError:
            raise


def children(observation):
    """Takes memory by children, each below the limit."""
    for _ in range(8):
        if os.fork() == 0:
            heap = b"x" * (40 << 20)
            time.sleep(60)
    _, status = os.wait()
    raise RuntimeError(f"a child ended: {status}")


def children_print(observation):
    """A child prints without end."""
    if os.fork() == 0:
        while True:
            os.write(1, b"x" * 4096)
    os.wait()


def descriptors(observation):
    """Opens more files than a process may have."""
    files = [open("/dev/null") for _ in range(1000)]
    return f"{len(files)} files"


def direct_reads(observation):
    """Reads around the page cache, from the disk that everybody needs."""
    got = None
    for attempt in (
        lambda: os.open(LIBRARY, os.O_RDONLY | os.O_DIRECT),
        lambda: fcntl.fcntl(os.open(LIBRARY, os.O_RDONLY), fcntl.F_SETFL, os.O_DIRECT),
    ):
        try:
            attempt()
            got = "the disk"
        except OSError as error:
            print("held:", error)
    return got


def flood(observation):
    """Prints without end."""
    while True:
        print("water" * 100)


def flushes(observation):
    """Has the disk of the host write its cache again and again: each fsync of a library took 3 ms."""
    for name in ("/usr/lib", LIBRARY):
        os.fsync(os.open(name, os.O_RDONLY))
    for flush in (os.fsync, os.fdatasync):
        try:
            flush(os.pipe()[1])
            print("held: the call does nothing")
        except OSError as error:
            print("GOT an answer of the kernel:", error)


def giant_line(observation):
    """One line of 8 MiB."""
    sys.stdout.write("x" * (8 << 20))


def heap(observation):
    """Takes memory without end."""
    kept = []
    while True:
        kept.append(bytearray(1 << 20))


def huge_pages(observation):
    """Takes huge pages, which no limit of memory counts: the answer is not always that there are some."""
    LIBC.mmap.restype = ctypes.c_void_p
    start = LIBC.mmap(None, 2 << 20, 3, MAP_PRIVATE | MAP_ANONYMOUS | MAP_HUGETLB, -1, 0)
    if start == ctypes.c_void_p(-1).value and ctypes.get_errno() == 1:
        raise PermissionError("huge pages")
    return "the kernel's stock of huge pages"


def memfd(observation):
    """Memory that is in no address space."""
    return os.memfd_create("heap")


def native_stack(observation):
    """Overflows the stack of native code."""

    def dive(_):
        [0].sort(key=dive)

    sys.setrecursionlimit(10**8)
    dive(0)


def numpy(observation):
    """One array beyond the limit."""
    import numpy as np

    return np.ones((1 << 13, 1 << 13))[0, 0] == 0  # 512 MiB


def recursion(observation):
    """Calls itself for ever."""
    return recursion(observation)


def shm(observation):
    """Fills shared memory."""
    return filled("dev/shm")


def stderr(observation):
    """Prints errors without end."""
    while True:
        os.write(2, b"water" * 1000)


def tmp(observation):
    """Fills /tmp."""
    return filled("tmp")


def filled(folder):
    """Write 64 MiB, in files of 8 MiB: no single one is too large."""
    for number in range(8):
        with open(f"/{folder}/full-{number}", "wb") as file:
            file.write(bytes(8 << 20))
    return f"64 MiB in /{folder}"

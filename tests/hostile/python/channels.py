"""Leaves bits where another box could read them, or reads what others left."""

import ctypes
import fcntl
import mmap
import os
import socket
import struct
import time

HELD = OSError, ValueError
LIBC = ctypes.CDLL(None, use_errno=True)
LIBRARY = "/usr/lib/x86_64-linux-gnu/libm.so.6"  # one file for all boxes
CACHESTAT, MINCORE, READAHEAD, INOTIFY_INIT1, FANOTIFY_INIT = 451, 27, 187, 294, 300  # x86_64
MADV_COLD, MADV_PAGEOUT = 20, 21
F_GET_RW_HINT, F_SET_RW_HINT = 1035, 1036


def library():
    return os.open(LIBRARY, os.O_RDONLY)


def call(number, *arguments):
    """Return the kernel's answer; OSError if it refuses."""
    answer = LIBC.syscall(number, *arguments)
    if answer < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return answer


def any_of(*attempts):
    """Make all attempts; return what the last one got that was not refused."""
    got = None
    for name, attempt in attempts:
        try:
            attempt()
            got = name
        except OSError as error:
            print("held:", name, error)
    return got


def cache_state(observation):
    """Counts the cached pages of a library."""
    everything, state = (ctypes.c_uint64 * 2)(), (ctypes.c_uint64 * 5)()
    call(CACHESTAT, library(), everything, state, 0)
    return "a count of cached pages"


def cached(observation):
    """Asks whether a page of a library is in the page cache."""
    os.preadv(library(), [bytearray(4096)], 0, os.RWF_NOWAIT)
    return "a view of the page cache"


def device_times(observation):
    """Sets the times of a device file, which all boxes see."""

    mark = time.time_ns() - 10**9

    def leave(device):
        os.utime(device, ns=(mark, mark))
        if os.stat(device).st_mtime_ns != mark:
            raise OSError("the time did not stay")

    devices = (0, "/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom")
    return any_of(*((f"a time of {one}", lambda one=one: leave(one)) for one in devices))


def disk_usage(observation):
    """Asks how full the disk of the host is."""
    folders = ("/", "/tmp", "/usr/lib", "/dev")
    return any_of(*((f"space of {one}", lambda one=one: os.statvfs(one)) for one in folders))


def evict(observation):
    """Drops the libraries of all boxes from the page cache."""
    os.posix_fadvise(library(), 0, 0, os.POSIX_FADV_DONTNEED)
    return "a way to empty the page cache"


def merged_pages(observation):
    """Has the kernel merge equal pages: the time of a write tells who has the same."""
    mmap.mmap(-1, 1 << 20).madvise(mmap.MADV_MERGEABLE)
    return "merged pages"


def mincore(observation):
    """Asks which pages of a library are in memory."""
    pages = mmap.mmap(library(), 4096, flags=mmap.MAP_PRIVATE)
    start = ctypes.addressof(ctypes.c_char.from_buffer(pages))
    call(MINCORE, ctypes.c_void_p(start), ctypes.c_size_t(4096), ctypes.create_string_buffer(1))
    return "a view of memory"


def out_of_band(observation):
    """Sends a byte out of band through a pair of sockets."""
    stream, packets = socket.socketpair(), socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    return any_of(
        ("a byte sent", lambda: stream[0].send(b"x", socket.MSG_OOB)),
        ("a byte received", lambda: stream[1].recv(1, socket.MSG_OOB | socket.MSG_DONTWAIT)),
        ("a byte sent as a packet", lambda: packets[0].send(b"x", socket.MSG_OOB)),
    )


def page_out(observation):
    """Has the kernel reclaim the pages of a library."""
    pages = mmap.mmap(library(), 4096, prot=mmap.PROT_READ)
    return any_of(
        ("cold pages", lambda: pages.madvise(MADV_COLD)),
        ("pages out of memory", lambda: pages.madvise(MADV_PAGEOUT)),
    )


def read_ahead(observation):
    """Loads a library into the page cache without reading it."""
    call(READAHEAD, library(), ctypes.c_long(0), ctypes.c_size_t(4096))
    return "a page in the cache"


def watch_files(observation):
    """Watches when others open the libraries."""
    folder = os.open("/usr/lib", os.O_RDONLY)
    return any_of(
        ("inotify", lambda: call(INOTIFY_INIT1, 0, 0)),
        ("fanotify", lambda: call(FANOTIFY_INIT, 0, 0)),
        ("a signal", lambda: fcntl.fcntl(folder, fcntl.F_NOTIFY, fcntl.DN_ACCESS)),
    )


def write_hints(observation):
    """Leaves three bits at a library: how long what is written there will live."""
    file = library()

    def ask(command):
        fcntl.fcntl(file, command, struct.pack("Q", 3))

    commands = (F_GET_RW_HINT, F_SET_RW_HINT, fcntl.F_GETLEASE)
    return any_of(*((f"command {one}", lambda one=one: ask(one)) for one in commands))

"""Looks for what the host has, and for what another program left; leaves traps."""

import ctypes
import glob
import os
import socket
import sys

HELD = OSError, ValueError
OWN_VARIABLES = {  # of the box
    *("PATH", "HOME", "LANG", "LC_CTYPE", "PWD", "PYTHONHASHSEED", "PYTHONPATH"),
    *("OPENBLAS_NUM_THREADS", "OPENBLAS_CORETYPE", "OMP_NUM_THREADS", "OPENCV_FOR_THREADS_NUM"),
    *("ORT_DISABLE_TELEMETRY", "MALLOC_ARENA_MAX"),
}
HOST_FILES = (
    *("/etc", "/home", "/root", "/var", "/proc", "/sys", "/run", "/opt"),
    *("/usr/local", "/usr/bin/sh"),
)


def open_descriptors():
    for number in range(3, 1024):
        try:
            os.fstat(number)
        except OSError:
            continue
        yield number


def descriptors(observation):
    """Uses descriptors that were left open, beside the connection."""
    return [*open_descriptors()][1:]


def environment(observation):
    """Looks for variables of the worker."""
    return sorted(set(os.environ) - OWN_VARIABLES)


def fifo(observation):
    """Leaves a FIFO that would hold the reader."""
    os.mkfifo("/tmp/output.txt")
    return "a FIFO"


def host_files(observation):
    """Looks for any folder of the host."""
    return [name for name in HOST_FILES if os.path.exists(name)]


def kernel_log(observation):
    """Reads the kernel's log."""
    read_all = 3
    libc = ctypes.CDLL(None)
    return libc.klogctl(read_all, ctypes.create_string_buffer(4096), 4096) > 0


def left_over(observation):
    """Finds what another program left, leaves something itself."""
    got = os.listdir("/tmp") + os.listdir("/dev/shm")
    for folder in ("/tmp", "/dev/shm"):
        open(folder + "/left", "w").close()
    return got


def new_device(observation):
    """Makes a device node of the disk, to read it."""
    disks = [open(name).read() for name in glob.glob("/sys/block/[!l]*/dev")]  # none in a box
    major, _, minor = (disks or ["8:0"])[0].partition(":")
    os.mknod("/tmp/disk", 0o60600, os.makedev(int(major), int(minor)))
    return "a node of the disk"


def peer(observation):
    """Asks who is at the other end of the connection."""
    channel = socket.socket(fileno=os.dup(next(open_descriptors())))
    got = None
    for option in (17, 59, 77):  # SO_PEERCRED, SO_PEERGROUPS, SO_PEERPIDFD
        try:
            channel.getsockopt(socket.SOL_SOCKET, option, 64)
            got = "a handle of the worker, or its name"
        except OSError as error:
            print("held:", error)
    print(channel.getsockopt(socket.SOL_SOCKET, socket.SO_TYPE))
    return got


def poison_library(observation):
    """Writes a compiled file into the standard library."""
    folder = os.path.dirname(os.__file__)
    open(folder + "/__pycache__/os.cpython-311.pyc", "wb").close()
    return folder


def poison_packages(observation):
    """Writes into the packages of the next run."""
    import numpy

    folder = os.path.dirname(numpy.__file__)
    open(folder + "/poison.py", "w").close()
    return folder


def proc_1_environ(observation):
    """Reads what bubblewrap was started with."""
    return open("/proc/1/environ", "rb").read()


def proc_parent(observation):
    """Reads the memory map of the parent."""
    return open(f"/proc/{os.getppid()}/maps").readline()


def read_shadow(observation):
    """Reads the host's passwords."""
    try:
        return f"{len(open('/etc/shadow').read())} characters of passwords"
    except OSError as error:
        raise RuntimeError(f"FileNotFoundError: {error}") from None


def stdin(observation):
    """Reads the worker's input."""
    return sys.stdin.read()


def symlink(observation):
    """Leaves a link to a file of the host."""
    os.symlink("/etc/shadow", "/tmp/output.txt")
    return "a link"


def write_root(observation):
    """Writes beside the runner."""
    open("/box/runner.py", "a").close()
    return "the runner"

"""Speaks to anybody: other machines, other boxes, the kernel, the trusted side."""

import array
import ctypes
import fcntl
import os
import socket

HELD = OSError, ValueError
LIBC = ctypes.CDLL(None, use_errno=True)
ADD_KEY, KEYCTL, MQ_OPEN, SHMGET = 248, 250, 240, 29  # x86_64


def call(number, *arguments):
    """Return the kernel's answer; OSError if it refuses."""
    answer = LIBC.syscall(number, *arguments)
    if answer < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return answer


def protocol():
    """Return the descriptor of the connection to the trusted side."""
    for number in range(3, 256):
        try:
            os.fstat(number)
        except OSError:
            continue
        return number


def alg(observation):
    """Makes a socket of the kernel's cryptography."""
    return socket.socket(socket.AF_ALG, socket.SOCK_SEQPACKET)


def file_lock(observation):
    """Signals to other boxes by file locks."""
    with open(os.__file__) as file:
        fcntl.lockf(file, fcntl.LOCK_SH)
    return "a lock"


def flock(observation):
    """Signals to other boxes by flock."""
    with open(os.__file__) as file:
        fcntl.flock(file, fcntl.LOCK_SH)
    return "a lock"


def keyctl(observation):
    """Opens the keyring of the user."""
    call(KEYCTL, 0, -4, 1, 0, 0)
    return "the keyring of the user"


def keyring(observation):
    """Puts a key where other boxes could read it."""
    call(ADD_KEY, b"user", b"name", b"secret", 6, -3)
    return "a key in the session's keyring"


def message_queue(observation):
    """Makes a POSIX message queue."""
    call(MQ_OPEN, b"queue", 0o102, 0o666, None)
    return "a message queue"


def name(observation):
    """Asks for an address, and calls there."""
    address = socket.getaddrinfo("localhost", 80, proto=socket.IPPROTO_TCP)[0][4]
    return socket.create_connection(address[:2], 1)


def netlink(observation):
    """Makes a netlink socket."""
    return socket.socket(socket.AF_NETLINK, socket.SOCK_RAW)


def packet(observation):
    """Makes a packet socket."""
    return socket.socket(socket.AF_PACKET, socket.SOCK_RAW)


def pass_descriptor(observation):
    """Sends a descriptor to the trusted side."""
    channel = socket.socket(fileno=os.dup(protocol()))
    channel.sendmsg([b"x"], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array("i", [0]))])
    return "a descriptor sent"


def shared_memory(observation):
    """Makes System V shared memory."""
    call(SHMGET, 1234, 4096, 0o1666)
    return "shared memory"


def tcp(observation):
    """Makes a TCP socket."""
    return socket.socket(socket.AF_INET, socket.SOCK_STREAM)


def tcp6(observation):
    """Makes a TCP socket of version 6."""
    return socket.socket(socket.AF_INET6, socket.SOCK_STREAM)


def udp(observation):
    """Makes a UDP socket."""
    return socket.socket(socket.AF_INET, socket.SOCK_DGRAM)


def unix(observation):
    """Makes a Unix socket, for abstract names."""
    return socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)


def vsock(observation):
    """Makes a socket to the hypervisor: no namespace holds it."""
    return socket.socket(socket.AF_VSOCK, socket.SOCK_STREAM)

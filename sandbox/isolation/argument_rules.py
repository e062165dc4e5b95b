"""The system calls that are refused for some of their arguments: data for the filter.

A refused call fails like on a kernel or a file system without the feature, so that libraries do
without it. Only the lower 32 bits are compared: the kernel uses no more of these arguments.
"""

import errno
from enum import Enum, auto
from typing import NamedTuple


class Test(Enum):
    """How the value of an argument is compared with those of a rule."""

    LISTED = auto()
    NOT_LISTED = auto()
    ANY_BIT = auto()


class Refusal(NamedTuple):
    """For which values of an argument a call fails."""

    argument: int  # its position, from 0
    test: Test
    values: tuple[int, ...]
    error: int = errno.EPERM
    when: tuple[int, int] | None = None  # only if the argument at this position has this value


# NEWNS NEWCGROUP NEWUTS NEWIPC NEWUSER NEWPID NEWNET (linux/sched.h); NEWTIME is clone3 only
CLONE_NEW_NAMESPACES = 0x7E020000
AF_UNIX = 1
# PEEK TRUNC DONTWAIT EOR WAITALL NOSIGNAL MORE CMSG_CLOEXEC (linux/socket.h), hence not OOB: its
# code has no use here, and had flaws (CVE-2025-38236)
MSG_ALLOWED = 0x2 | 0x20 | 0x40 | 0x80 | 0x100 | 0x4000 | 0x8000 | 0x40000000
# TYPE ERROR SNDBUF RCVBUF RCVTIMEO SNDTIMEO ACCEPTCONN PROTOCOL DOMAIN, hence not PEERCRED,
# PEERPIDFD and PEERGROUPS: they describe the worker (asm-generic/socket.h)
SOCKET_OPTIONS_ALLOWED = (3, 4, 7, 8, 20, 21, 30, 38, 39)
# TCGETS TIOCGWINSZ FIONREAD FIONBIO FIONCLEX FIOCLEX (asm-generic/ioctls.h)
IOCTL_ALLOWED = (0x5401, 0x5413, 0x541B, 0x5421, 0x5450, 0x5451)
# GET/SET_DUMPABLE SET/GET_NAME GET_SECCOMP SET/GET_NO_NEW_PRIVS SET_VMA (linux/prctl.h)
PRCTL_ALLOWED = (3, 4, 15, 16, 21, 38, 39, 0x53564D41)
# DUPFD GETFD SETFD GETFL SETFL DUPFD_CLOEXEC GETPIPE_SZ GET_SEALS (linux/fcntl.h), hence not locks,
# leases, NOTIFY and RW_HINT (channels between boxes) nor SETPIPE_SZ (memory)
FCNTL_ALLOWED = (0, 1, 2, 3, 4, 1030, 1032, 1034)
F_SETFL = 4
O_DIRECT = 0x4000  # reads of the host's disk that no cache makes cheap (asm-generic/fcntl.h)
MAP_HUGETLB = 0x40000  # a stock of the whole host, which counts for no box (linux/mman.h)
# NORMAL RANDOM SEQUENTIAL WILLNEED DONTNEED FREE DONTFORK DOFORK HUGEPAGE NOHUGEPAGE DONTDUMP
# DODUMP WIPEONFORK KEEPONFORK POPULATE_READ POPULATE_WRITE COLLAPSE GUARD_INSTALL GUARD_REMOVE
# (asm-generic/mman-common.h), hence not MERGEABLE (shows what other boxes have in memory), COLD and
# PAGEOUT (empty the page cache)
MADVISE_ALLOWED = (0, 1, 2, 3, 4, 8, 10, 11, 14, 15, 16, 17, 18, 19, 22, 23, 25, 102, 103)
# At the lowest value it can have, 1, no handler of crashes is started on the host; at 0, the usual
# way to switch core dumps off, one is (core(5), fs/coredump.c).
RLIMIT_CORE = 4  # asm-generic/resource.h
NO_FLAGS = (0,)  # RWF_NOWAIT shows what is in the page cache

_UNKNOWN_FLAG = errno.EOPNOTSUPP
_DIRECT = (O_DIRECT,)

# The most frequent ones come first: the kernel goes through them one by one.
REFUSALS: dict[str, tuple[Refusal, ...]] = {
    "recvfrom": (Refusal(3, Test.ANY_BIT, (0xFFFFFFFF & ~MSG_ALLOWED,), _UNKNOWN_FLAG),),
    "sendto": (Refusal(3, Test.ANY_BIT, (0xFFFFFFFF & ~MSG_ALLOWED,), _UNKNOWN_FLAG),),
    "mmap": (Refusal(3, Test.ANY_BIT, (MAP_HUGETLB,)),),
    "madvise": (Refusal(2, Test.NOT_LISTED, MADVISE_ALLOWED, errno.EINVAL),),
    "open": (Refusal(1, Test.ANY_BIT, _DIRECT, errno.EINVAL),),
    "openat": (Refusal(2, Test.ANY_BIT, _DIRECT, errno.EINVAL),),
    "fcntl": (
        Refusal(1, Test.NOT_LISTED, FCNTL_ALLOWED),
        Refusal(2, Test.ANY_BIT, _DIRECT, errno.EINVAL, when=(1, F_SETFL)),
    ),
    "preadv2": (Refusal(5, Test.NOT_LISTED, NO_FLAGS, _UNKNOWN_FLAG),),
    "pwritev2": (Refusal(5, Test.NOT_LISTED, NO_FLAGS, _UNKNOWN_FLAG),),
    "clone": (Refusal(0, Test.ANY_BIT, (CLONE_NEW_NAMESPACES,)),),
    "socketpair": (Refusal(0, Test.NOT_LISTED, (AF_UNIX,)),),
    "getsockopt": (Refusal(2, Test.NOT_LISTED, SOCKET_OPTIONS_ALLOWED, errno.ENOPROTOOPT),),
    "ioctl": (Refusal(1, Test.NOT_LISTED, IOCTL_ALLOWED, errno.ENOTTY),),
    "prctl": (Refusal(0, Test.NOT_LISTED, PRCTL_ALLOWED),),
    "setrlimit": (Refusal(0, Test.LISTED, (RLIMIT_CORE,)),),
    "prlimit64": (
        Refusal(0, Test.NOT_LISTED, (0,)),  # of the calling process only
        Refusal(1, Test.LISTED, (RLIMIT_CORE,)),
    ),
}

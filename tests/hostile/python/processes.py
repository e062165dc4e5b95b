"""Reaches for other processes and for what the kernel keeps for root.

Where the whole attack would harm a machine without a box, it takes the smallest step that a guard
has to refuse: the kernel's answer says whether it was reached.
"""

import ctypes
import errno
import fcntl
import mmap
import os
import resource
import signal
import struct
import subprocess
import threading
import time

HELD = OSError, ValueError
LIBC = ctypes.CDLL(None, use_errno=True)
# x86_64
CLONE, PTRACE, MOUNT, REBOOT, SETHOSTNAME, INIT_MODULE, SETTIMEOFDAY = (
    56,
    101,
    165,
    169,
    170,
    175,
    164,
)
CLOCK_SETTIME, UNSHARE, PERF_EVENT_OPEN, PRLIMIT, SETNS, PROCESS_VM_READV = (
    227,
    272,
    298,
    302,
    308,
    310,
)
BPF, USERFAULTFD, IO_URING_SETUP, FSOPEN, PIDFD_OPEN = 321, 323, 425, 430, 434
X32 = 0x40000000
NEW_USER = 0x10000000


def call(number, *arguments):
    """Return the kernel's answer; OSError if it refuses."""
    answer = LIBC.syscall(number, *arguments)
    if answer < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return answer


def reached(number, *arguments):
    """Return that the kernel looked at the arguments, whatever it thinks of them."""
    try:
        call(number, *arguments)
    except OSError as error:
        if error.errno in (errno.EPERM, errno.ENOSYS):
            raise
        return f"an answer of the kernel: {error}"
    return "what it asked for"


def affinity(observation):
    """Leaves its core."""
    os.sched_setaffinity(0, range(os.cpu_count()))
    return "all cores"


def bpf(observation):
    """Loads a program into the kernel, or at least the map that it would need."""
    create_map, array_type, key_bytes, value_bytes, entries = 0, 2, 4, 4, 1
    attributes = struct.pack("4I", array_type, key_bytes, value_bytes, entries)
    call(BPF, create_map, ctypes.create_string_buffer(attributes, 64), 64)
    return "a map of BPF"


def chroot(observation):
    """Changes the root."""
    os.chroot("/tmp")
    return "another root"


def clock(observation):
    """Sets the clock: to a time that there is not, and to no time."""
    got = reached(CLOCK_SETTIME, 0, struct.pack("qq", 0, 2_000_000_000))
    call(SETTIMEOFDAY, None, None)
    return got


def clone_namespace(observation):
    """Makes a user namespace by clone, high bits set."""
    if call(CLONE, ctypes.c_uint64(0xFFFFFFFF00000011 | NEW_USER), None, None, None, None) == 0:
        os._exit(0)
    return "a process in a user namespace"


def core_dump(observation):
    """Switches core dumps on."""
    resource.setrlimit(resource.RLIMIT_CORE, (1 << 30, 1 << 30))
    return "core dumps"


def core_handler(observation):
    """Lowers the limit of core dumps: at 0 the host's handler of crashes runs."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    return "a crash that a program of the host handles"


def fork_bomb(observation):
    """Forks without end."""
    while True:
        os.fork()


def fork_sleepers(observation):
    """Starts sleeping children without end."""
    while True:
        if os.fork() == 0:
            time.sleep(60)


def hostname(observation):
    """Renames the host."""
    call(SETHOSTNAME, b"owned", 5)
    return "the name of the host"


def i386_call(observation):
    """Calls the kernel by the numbers of i386."""
    page = mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC)
    page.write(bytes.fromhex("b814000000cd80c3"))  # mov eax, getpid; int 0x80; ret
    address = ctypes.addressof(ctypes.c_char.from_buffer(page))
    return f"the pid {ctypes.CFUNCTYPE(ctypes.c_int)(address)()}"


def io_uring(observation):
    """Makes a queue past the filter."""
    call(IO_URING_SETUP, 4, ctypes.create_string_buffer(256))
    return "a queue of system calls"


def kill_all(observation):
    """Kills what it can see: a process of others; if there is none, everything, init too."""
    for pid in set(range(2, 1000)) - {os.getpid(), os.getppid()}:
        try:
            os.kill(pid, signal.SIGKILL)
        except OSError:
            continue
        return f"process {pid}"
    os.kill(1, signal.SIGKILL)
    os.kill(-1, signal.SIGKILL)


def module(observation):
    """Loads a kernel module, of no bytes."""
    return reached(INIT_MODULE, b"", 0, b"")


def mount(observation):
    """Mounts a file system."""
    call(MOUNT, b"none", b"/tmp", b"tmpfs", 0, None)
    return "a file system"


def new_mount(observation):
    """Mounts by the new calls."""
    call(FSOPEN, b"tmpfs", 0)
    return "a file system"


def perf(observation):
    """Measures how long others run."""
    software, cpu_clock, size = 1, 0, 64
    attributes = struct.pack("2IQ", software, size, cpu_clock)
    call(PERF_EVENT_OPEN, ctypes.create_string_buffer(attributes, 128), -1, 0, -1, 0)
    return "a counter of a core"


def pidfd(observation):
    """Takes a descriptor of another process."""
    call(PIDFD_OPEN, os.getppid(), 0)
    return "a descriptor of the parent"


def priority(observation):
    """Takes precedence."""
    os.setpriority(os.PRIO_PROCESS, 0, -20)
    return "precedence"


def prlimit(observation):
    """Changes the limits of init."""
    call(PRLIMIT, os.getppid(), 7, None, ctypes.create_string_buffer(16))
    return "the limits of the parent"


def process_vm(observation):
    """Reads another process's memory."""
    return reached(PROCESS_VM_READV, os.getppid(), None, 0, None, 0, 0)


def ptrace(observation):
    """Attaches to bubblewrap's init."""
    seize = 0x4206
    call(PTRACE, seize, os.getppid(), 0, 0)
    return "the parent"


def raise_limits(observation):
    """Raises its own limits."""
    resource.setrlimit(resource.RLIMIT_NOFILE, (256, 256))  # a box has 64
    return "more files"


def reboot(observation):
    """Ends the machine, by a command that no kernel knows."""
    return reached(REBOOT, 0xFEE1DEAD, 672274793, 1, None)


def sessions(observation):
    """Makes a session, to which some kernels give a CPU share of its own."""
    child = os.fork()
    if child == 0:
        try:
            os.setsid()
        except OSError:
            os._exit(0)
        os._exit(1)
    return os.waitpid(child, 0)[1] and "a session"


def setgroups(observation):
    """Joins other groups."""
    os.setgroups([0])
    return "a group"


def setns(observation):
    """Enters a namespace: its own one, if it can be opened."""
    try:
        own = os.open("/proc/self/ns/uts", os.O_RDONLY)
    except OSError:
        own = -1
    return reached(SETNS, own, 0)


def setuid(observation):
    """Becomes root."""
    os.setuid(0)
    return os.getuid() == 0


def shell(observation):
    """Starts a shell."""
    try:
        return subprocess.run(["/bin/sh", "-c", "id"], check=True)
    except OSError as error:
        raise RuntimeError(f"no shell: {error}") from None


def signal_parent(observation):
    """Ends bubblewrap's init, or stops it."""
    parent = os.getppid()
    for name in (signal.SIGTERM, signal.SIGHUP):
        os.kill(parent, name)
        time.sleep(0.1)  # a parent that is ended by the first one gets no second
        if os.getppid() != parent:
            return "the parent's end"
    os.kill(parent, signal.SIGSTOP)


def system(observation):
    """Starts a shell by system()."""
    return os.system("id") == 0


def terminal_input(observation):
    """Types into the terminal, high bits set (CVE-2019-10063)."""
    LIBC.ioctl.argtypes = (ctypes.c_int, ctypes.c_uint64, ctypes.c_char_p)
    if LIBC.ioctl(0, 0x100005412, b"x") != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return "a key pressed"


def threads(observation):
    """Starts threads without end."""
    while True:
        threading.Thread(target=time.sleep, args=(60,), daemon=True).start()


def user_namespace(observation):
    """Makes a user namespace, in which it is root."""
    call(UNSHARE, NEW_USER)
    return "a user namespace"


def userfaultfd(observation):
    """Holds the kernel at a page fault."""
    call(USERFAULTFD, 1)
    return "page faults"


def x32_call(observation):
    """Calls the kernel by the numbers of x32."""
    return f"the answer {LIBC.syscall(X32 | 39)}"

"""Calls programs outside the box: as root, with no filter and no limit, on copies of the machine.

What one does stays in its namespaces, whose init is a fork of this, and in its control group. The
root is an overlay: what is written there is gone afterwards. Beside the program there are, for
attacks to find: services on ports, a process of somebody else, a terminal, a secret.

Standard input is a socket. A message is a program: a descriptor to print to, and as JSON the files
by which a process joins its control groups, a folder for the overlay, a folder that it finds as
/attack, its command. The caller of a program in Python is a fork of this: nothing guards it there
either, and to start an interpreter with NumPy would take longer than most programs.
"""

import contextlib
import ctypes
import fcntl
import json
import os
import resource
import select
import shutil
import signal
import socket
import stat
import struct
import sys
import termios
import tty
from pathlib import Path
from types import ModuleType
from typing import NoReturn

LIBC = ctypes.CDLL(None, use_errno=True)
MS_BIND, MS_REC, MS_PRIVATE, MNT_DETACH = 0x1000, 0x4000, 1 << 18, 2
PIVOT_ROOT = 155  # x86_64
NAMESPACES = 0x6C020000  # CLONE_NEWNS, NEWUTS, NEWIPC, NEWPID, NEWNET
PR_SET_PDEATHSIG = 1
DEVICES = ("null", "zero", "full", "random", "urandom")
PORTS = (80, 5432, 8000)
LIBRARY = "/usr/lib/x86_64-linux-gnu/libm.so.6"
CALLER = "/attack/caller.py"  # this process becomes it
CHANNEL, REPORT = 3, 301  # descriptors of the program's caller


def mount(source: str, target: Path | str, kind: str, flags: int = 0, data: str = "") -> None:
    arguments = source.encode(), str(target).encode(), kind.encode(), flags, data.encode()
    if LIBC.mount(*arguments) != 0:
        raise OSError(ctypes.get_errno(), f"mount {source} {target}")


def report(text: str) -> None:
    os.write(1, f"\nCALLER: {text}\n".encode())


def enter_copy(folder: Path, attack: Path) -> None:
    """Make a copy of the machine's files the root."""
    mount("none", "/", "", MS_REC | MS_PRIVATE)
    mount("tmpfs", folder, "tmpfs", 0, "size=256m")
    upper, work, root = (folder / name for name in ("upper", "work", "root"))
    for one in (upper, work, root):
        one.mkdir()
    mount("overlay", root, "overlay", 0, f"lowerdir=/,upperdir={upper},workdir={work}")
    shutil.copytree(attack, root / "attack")
    shutil.copytree(attack / "box", root / "box", dirs_exist_ok=True)
    mount(
        LIBRARY, f"{root}{LIBRARY}", "", MS_BIND
    )  # an overlay does not answer all that a disk does
    mount("/sys", root / "sys", "", MS_BIND | MS_REC)
    mount("proc", root / "proc", "proc")
    make_devices(root / "dev")
    for name in ("tmp", "dev/shm"):
        mount("tmpfs", root / name, "tmpfs", 0, "size=256m,mode=1777")
        (root / name / "left-by-another").write_text("do you read me")
        uncover(name, root)
    old = root / "mnt"
    if LIBC.syscall(PIVOT_ROOT, str(root).encode(), str(old).encode()) != 0:
        raise OSError(ctypes.get_errno(), "pivot_root")
    os.chdir("/")
    LIBC.umount2(b"/mnt", MNT_DETACH)


def uncover(name: str, root: Path) -> None:
    """Show the interpreter and this checkout again where they are below a folder that is new."""
    for needed in {Path(sys.executable).parents[1], Path(__file__).resolve().parents[3]}:
        if needed.is_relative_to(f"/{name}"):
            shown = root / needed.relative_to("/")
            shown.mkdir(parents=True, exist_ok=True)
            mount(str(needed), shown, "", MS_BIND | MS_REC)


def make_devices(folder: Path) -> None:
    """Make nodes of its own: the times of the host's are kept."""
    mount("tmpfs", folder, "tmpfs", 0, "size=1m,mode=755")
    for name in DEVICES:
        os.mknod(folder / name, stat.S_IFCHR | 0o666, os.stat(f"/dev/{name}").st_rdev)
        (folder / name).chmod(0o666)
    (folder / "pts").mkdir()
    (folder / "shm").mkdir()
    mount("devpts", folder / "pts", "devpts", 0, "newinstance,ptmxmode=0666")
    (folder / "ptmx").symlink_to("pts/ptmx")


def services() -> list[socket.socket]:
    """Listen on the network's own loopback."""
    with socket.socket() as any_socket:
        up = struct.pack("16sh", b"lo", 1)
        fcntl.ioctl(any_socket, 0x8914, up)  # SIOCSIFFLAGS
    return [socket.create_server(("127.0.0.1", port)) for port in PORTS]


def terminal() -> int:
    """Return a terminal into which somebody typed a line, and the end of the input."""
    master, slave = os.openpty()  # this init keeps the other end: closing it would end the session
    settings = tty.tcgetattr(slave)
    settings[3] &= ~termios.ECHO
    tty.tcsetattr(slave, termios.TCSANOW, settings)
    os.write(master, b"a line of the worker\n\x04")
    return slave


def call(command: list[str], channel: int, slave: int) -> None:
    """Become the caller of the program."""
    os.setsid()
    fcntl.ioctl(slave, termios.TIOCSCTTY, 0)
    os.dup2(1, REPORT)
    os.dup2(slave, 0)
    os.dup2(channel, CHANNEL)
    for number in range(4, REPORT):
        with contextlib.suppress(OSError):
            os.close(number)
    os.dup2(os.open("/", os.O_RDONLY), 7)  # a descriptor that was left open
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(most, 4096), most))
    os.set_inheritable(7, True)
    os.chdir("/attack")
    if command[0] == CALLER:
        be_caller(command)
    os.execv(command[0], command)  # noqa: S606


def be_caller(command: list[str]) -> NoReturn:
    """Run a caller in Python as the main module, and end as an interpreter ends."""
    sys.argv = command
    main_module = sys.modules["__main__"] = ModuleType("__main__")
    main_module.__file__ = CALLER
    exec(compile(Path(CALLER).read_bytes(), CALLER, "exec"), main_module.__dict__)  # noqa: S102
    sys.exit()


def end_of(status: int) -> str:
    if os.WIFSIGNALED(status):
        return f"ended by {signal.Signals(os.WTERMSIG(status)).name}"
    return f"exited with {os.WEXITSTATUS(status)}"


def parent_of_caller(command: list[str], channel: int, slave: int) -> int:
    """Fork a process that starts the caller, waits for it and says how it ended."""
    parent = os.fork()
    if parent:
        return parent
    caller = os.fork()
    if caller == 0:
        call(command, channel, slave)
    report(end_of(os.waitpid(caller, 0)[1]))
    os._exit(0)


def answer(service: socket.socket) -> None:
    """Answer a client as a web server."""
    client, _ = service.accept()
    with client, contextlib.suppress(OSError):
        client.settimeout(0.2)
        client.recv(4096)
        client.sendall(b"HTTP/1.0 200 OK\r\n\r\nwelcome")


def watch(
    parent: int, victim: int, ours: socket.socket, listening: dict[int, socket.socket]
) -> None:
    """Report what arrives at the channel, until the caller has ended."""
    poll = select.poll()
    for descriptor in (ours.fileno(), *listening):
        poll.register(descriptor, select.POLLIN)
    ended = False
    while not ended:
        for descriptor, _ in poll.poll(5):
            if descriptor in listening:
                answer(listening[descriptor])
            elif arrived := ours.recv(1 << 17):
                report(f"arrived {len(arrived)} bytes: {arrived[:60]!r}")
            else:
                poll.unregister(ours)
        pid, status = os.waitpid(-1, os.WNOHANG)
        if pid == victim:
            report("a process of somebody else ended")
        if pid not in (0, parent, victim):
            report(end_of(status))
        ended = pid not in (0, parent, victim) or (pid == parent and os.WIFEXITED(status))


def main() -> None:
    """Let a fork make each machine: to start an interpreter with these modules takes longer."""
    requests = socket.socket(fileno=0)
    while True:
        message, descriptors, *_ = socket.recv_fds(requests, 1 << 16, 1)
        if not message:
            return
        if os.fork() == 0:
            return enter_namespaces(descriptors[0], *json.loads(message))
        os.close(descriptors[0])
        with contextlib.suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                pass


def enter_namespaces(output: int, groups: list[str], *machine: str) -> None:
    """Join the control groups, and let a fork be the init of new namespaces."""
    for number in (1, 2):
        os.dup2(output, number)
    os.close(output)
    os.dup2(os.open("/dev/null", os.O_RDONLY), 0)
    for file in groups:
        Path(file).write_text("0")
    if LIBC.unshare(NAMESPACES) != 0:
        raise OSError(ctypes.get_errno(), "unshare")
    child = os.fork()
    if child:
        os.waitpid(child, 0)
    else:
        LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        be_machine(*machine)


def be_machine(folder: str, attack: str, *command: str) -> None:
    """Show a program what it is to find, call it, and report what is seen of it."""
    enter_copy(Path(folder), Path(attack))
    listening = {service.fileno(): service for service in services()}
    victim = os.fork()
    if victim == 0:
        signal.pause()
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    parent = parent_of_caller([*command], theirs.fileno(), terminal())
    theirs.close()
    watch(parent, victim, ours, listening)
    with contextlib.suppress(ChildProcessError):
        if os.waitpid(victim, os.WNOHANG)[0]:
            report("a process of somebody else ended")
    left = {int(name) for name in os.listdir("/proc") if name.isdigit()} - {1, victim, parent}
    if left:
        report(f"left {len(left)} processes")


main()

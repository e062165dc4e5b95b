"""A controller that prints what it sees of its box: for each part the start of it, and a digest."""

import gc
import hashlib
import json
import locale
import os
import platform
import resource
import signal
import socket
import stat
import sys
import tempfile
import threading
import time


def tree(top):
    found = []
    for folder, _, files in os.walk(top):
        for name in sorted(files)[:50]:
            try:
                one = os.lstat(os.path.join(folder, name))
            except OSError:
                continue
            found.append((folder, name, one.st_size, one.st_mode, one.st_uid, one.st_mtime))
    return sorted(found)


def described(number):
    try:
        one = os.fstat(number)
    except OSError:
        return None
    return stat.S_IFMT(one.st_mode), one.st_uid


def attempt(action):
    try:
        return action()
    except Exception as error:
        return type(error).__name__


def handler(number):
    found = signal.getsignal(number)
    return getattr(found, "__name__", str(found))


def limit(name):
    return attempt(lambda: resource.getrlimit(getattr(resource, name)))


LIMITS = [name for name in dir(resource) if name.startswith("RLIMIT_")]
VIEW = {
    "arguments": sys.argv,
    "original_arguments": sys.orig_argv,
    "file": __file__,
    "code_file": (lambda: 0).__code__.co_filename,
    "modules": sorted(sys.modules),
    "module_path": sys.path,
    "flags": str(sys.flags),
    "hash": hash("seamark"),
    "version": sys.version,
    "environment": dict(os.environ),
    "folder": os.getcwd(),
    "top": sorted(os.listdir("/")),
    "temporary": tree("/tmp"),
    "shared": tree("/dev/shm"),
    "box": [row[:5] for row in tree("/box")],
    "devices": [row[:5] for row in tree("/dev")],
    "etc": tree("/etc"),
    "temporary_folder": tempfile.gettempdir(),
    "free": attempt(lambda: os.statvfs("/tmp").f_bfree),
    "host": socket.gethostname(),
    "system": os.uname(),
    "platform": platform.platform(),
    "users": (os.getuid(), os.getgid(), os.getgroups(), os.getresuid()),
    "processes": (os.getpid(), os.getppid(), os.getsid(0), os.getpgid(0)),
    "login": attempt(os.getlogin),
    "umask": os.umask(0),
    "descriptors": [described(number) for number in range(64)],
    "terminal": attempt(lambda: os.ttyname(0)),
    "limits": {name: limit(name) for name in LIMITS},
    "priority": attempt(lambda: os.getpriority(os.PRIO_PROCESS, 0)),
    "scheduler": attempt(lambda: os.sched_getscheduler(0)),
    "affinity_size": len(os.sched_getaffinity(0)),
    "cores": os.cpu_count(),
    "signals": [handler(n) for n in sorted(signal.valid_signals())],
    "blocked": sorted(map(int, signal.pthread_sigmask(signal.SIG_BLOCK, []))),
    "threads": threading.active_count(),
    "locale": (locale.getlocale(), locale.setlocale(locale.LC_ALL)),
    "zone": (time.tzname, time.timezone, time.localtime(0).tm_hour),
    "encodings": (sys.stdout.encoding, sys.getfilesystemencoding()),
    "recursion": sys.getrecursionlimit(),
    "collector": gc.isenabled(),
    "interfaces": attempt(socket.if_nameindex),
    "processor": platform.machine(),
    "proc": attempt(lambda: os.listdir("/proc")),
    "sys": attempt(lambda: os.listdir("/sys")),
    "clock": (time.time(), time.monotonic()),
    "random": os.urandom(8).hex(),
    "inode": os.stat("/tmp").st_ino,
}


def shown(value):
    text = repr(value)
    return text[:200], hashlib.sha256(text.encode()).hexdigest()


class Controller:
    def __init__(self, config):
        VIEW["config"] = dict(config)
        print(json.dumps({name: shown(value) for name, value in VIEW.items()}))

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]

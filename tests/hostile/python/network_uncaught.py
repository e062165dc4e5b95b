"""An honest program that wants the network."""

import socket


class Controller:
    def __init__(self, config):
        socket.create_connection(("127.0.0.1", 8000), 1)
        print("GOT a connection")

    def step(self, observation):
        return [0.0, 0.0, 0.0, 0.0]

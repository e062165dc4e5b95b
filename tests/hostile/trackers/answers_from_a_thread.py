"""Forges the answers in threads, beside the runner."""

import threading


def forge():
    while True:
        send(b"t", bytes(64), range(1, 40))


def attack(image):
    threading.Thread(target=forge, daemon=True).start()

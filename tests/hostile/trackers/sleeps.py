"""Waits for ever."""

import time


def attack(image):
    time.sleep(60)

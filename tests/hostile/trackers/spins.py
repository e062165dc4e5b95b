"""Takes for ever."""


def attack(image):
    while True:
        pass

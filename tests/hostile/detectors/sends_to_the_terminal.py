"""A text that calls itself printable, to clear the terminal of who reads the log."""


def attack(image):
    class Label(str):
        def isprintable(self):
            return True

    return [(Label("\x1b[2Jbox"), CORNERS, 0.5)]

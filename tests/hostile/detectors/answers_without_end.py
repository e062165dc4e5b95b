"""Returns a list that never ends."""


def attack(image):
    class Endless(list):
        def __iter__(self):
            while True:
                yield "box", CORNERS, 0.5

    return Endless()

"""Answers with an object that pretends to be an array."""


def attack(image):
    class Pretender:
        shape = (4, 2)

        def __array__(self, *rest, **more):
            return self.no

    return Pretender()

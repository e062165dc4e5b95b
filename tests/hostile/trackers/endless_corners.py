"""Answers with corners without an end."""


def attack(image):
    class Endless(list):
        def __iter__(self):
            return iter(int, 1)

        def __len__(self):
            return 4

    return Endless([[1.0, 2.0]] * 4)

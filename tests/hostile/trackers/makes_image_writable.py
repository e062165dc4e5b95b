"""Switches the protection of the image off."""


def attack(image):
    image.setflags(write=True)
    image[0, 0] = 1
    print("GOT a writable image")

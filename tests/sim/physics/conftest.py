"""Property tests of this folder have no deadline: the first call of a kernel may compile it."""

from hypothesis import settings

settings.register_profile("physics", deadline=None, derandomize=True)
settings.load_profile("physics")

"""Images for a program: memory that we write and a box can only read.

The memory is a memfd. Before its descriptor is handed out it gets its final size and is sealed: it
can neither shrink nor grow, and only the mapping that we made before can write it. We write it and
never read it back: whatever a program does to it, we are not affected. Pages are allocated by the
first write: a box that is given no images uses none.

There are three slots. The image that a tracker starts with stays in the first one; updates
alternate between the other two, so that the previous image is still readable.
"""

import fcntl
import mmap
import os

from seamark.sandbox.languages.inside.wire import IMAGE

SLOTS = 3
MAX_IMAGE_BYTES = 4 << 20  # [B] one image: 640x480 in colour has 0.9 MiB
COLOURS = 3

SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
F_SEAL_FUTURE_WRITE = 0x10  # linux/fcntl.h, since Linux 5.1; Python 3.11 has no name for it


class SharedImages:
    """The shared memory of one box."""

    def __init__(self) -> None:
        writing = os.memfd_create("images", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(writing, SLOTS * MAX_IMAGE_BYTES)
            self._memory = mmap.mmap(writing, SLOTS * MAX_IMAGE_BYTES)
            fcntl.fcntl(writing, fcntl.F_ADD_SEALS, SEALS | F_SEAL_FUTURE_WRITE)
            # In addition to the seal: this descriptor was never open for writing.
            self.descriptor = os.open(f"/proc/self/fd/{writing}", os.O_RDONLY | os.O_CLOEXEC)
        finally:
            os.close(writing)
        self._updates = 0

    @staticmethod
    def description(descriptor: int) -> dict[str, int]:
        """Return what a program needs to map the memory; `descriptor` is the number in the box."""
        return {"descriptor": descriptor, "bytes": SLOTS * MAX_IMAGE_BYTES}

    def put_first(self, image: object) -> bytes:
        """Store the image that a tracker starts with; return its IMAGE header."""
        return self._put(0, image)

    def put_next(self, image: object) -> bytes:
        """Store an image over the last but one; return its IMAGE header."""
        self._updates += 1
        return self._put(1 + self._updates % (SLOTS - 1), image)

    def _put(self, slot: int, image: object) -> bytes:
        view = memoryview(image)  # type: ignore[arg-type]
        shape = view.shape or ()
        fits = len(shape) == 2 or (len(shape) == 3 and shape[2] == COLOURS)
        fits = fits and view.c_contiguous and 0 < view.nbytes <= MAX_IMAGE_BYTES
        if view.format != "B" or not fits:
            raise ValueError(
                f"an image is C-contiguous uint8 of (H, W) or (H, W, {COLOURS}) and has at most "
                f"{MAX_IMAGE_BYTES} bytes, not {view.format!r} of {shape}"
            )
        offset = slot * MAX_IMAGE_BYTES
        self._memory[offset : offset + view.nbytes] = view.cast("B")
        return IMAGE.pack(offset, *shape[:2], COLOURS if len(shape) == 3 else 1)

    def close(self) -> None:
        """Release the memory; a second call does nothing."""
        self._memory.close()
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

"""Images for a program: memory that the trusted side writes and a box can only read.

The memory is a memfd. Before its descriptor is handed out it gets its size and is sealed: it can
neither shrink nor grow, and nothing but the mapping that the trusted side made before can write it.
The trusted side only writes and never reads it: whatever a program tried, it could not lead us
astray. Pages exist from the first write on: a box that sees no images costs none.

Images come in three places. The one that a tracker starts with stays in the first; those of its
updates change between the other two, so that the image of the update before is still there.
"""

import fcntl
import mmap
import os
import struct

PLACES = 3
MOST_BYTES = 4 << 20  # [B] one image: 640x480 in colour has 0.9 MiB
PICTURE = struct.Struct("<4I")  # offset [B], height, width [px], channels
COLOURS = 3

SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_SEAL
F_SEAL_FUTURE_WRITE = 0x10  # linux/fcntl.h, since Linux 5.1; Python 3.11 has no name for it


class Pictures:
    """The shared memory of one box."""

    def __init__(self) -> None:
        writing = os.memfd_create("images", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.ftruncate(writing, PLACES * MOST_BYTES)
            self._memory = mmap.mmap(writing, PLACES * MOST_BYTES)
            fcntl.fcntl(writing, fcntl.F_ADD_SEALS, SEALS | F_SEAL_FUTURE_WRITE)
            # A second lock on the same door: this descriptor was never open for writing.
            self.descriptor = os.open(f"/proc/self/fd/{writing}", os.O_RDONLY | os.O_CLOEXEC)
        finally:
            os.close(writing)
        self._updates = 0

    @staticmethod
    def described(descriptor: int) -> dict[str, int]:
        """Return what a program has to know to map the memory; the number is that in the box."""
        return {"descriptor": descriptor, "bytes": PLACES * MOST_BYTES}

    def first(self, image: object) -> bytes:
        """Put an image where it stays until the next first one; return the frame's words on it."""
        return self._put(0, image)

    def next(self, image: object) -> bytes:
        """Put an image in the place of the last but one; return the frame's words on it."""
        self._updates += 1
        return self._put(1 + self._updates % (PLACES - 1), image)

    def _put(self, place: int, image: object) -> bytes:
        view = memoryview(image)  # type: ignore[arg-type]
        shape = view.shape or ()
        fits = len(shape) == 2 or (len(shape) == 3 and shape[2] == COLOURS)
        fits = fits and view.c_contiguous and 0 < view.nbytes <= MOST_BYTES
        if view.format != "B" or not fits:
            raise ValueError(
                f"an image is C-contiguous uint8 of (H, W) or (H, W, {COLOURS}) and has at most "
                f"{MOST_BYTES} bytes, not {view.format!r} of {shape}"
            )
        offset = place * MOST_BYTES
        self._memory[offset : offset + view.nbytes] = view.cast("B")
        return PICTURE.pack(offset, *shape[:2], COLOURS if len(shape) == 3 else 1)

    def close(self) -> None:
        """Give the memory back; a second call does nothing."""
        self._memory.close()
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

"""Images for a program: memory that we write and a box can only read.

The memory is a memfd. Before its descriptor is handed out it gets its final size and is sealed: it
can neither shrink nor grow, and only the mapping that we made before can write it. We write it and
never read it back: whatever a program does to it, we are not affected. Pages are allocated by the
first write: a box that is given no images uses none.

A tracker has three slots: the image that it starts with stays in the first one; updates alternate
between the other two, so that the previous image is still readable. A controller has two for each
camera, which its images alternate between for the same reason.
"""

import fcntl
import mmap
import os

from seamark.sandbox.languages.inside.wire import IMAGE

SLOTS = 3
MAX_IMAGE_BYTES = 4 << 20  # [B] one image: 640x480 in colour has 0.9 MiB
COLOURS = 3
MAX_CAMERAS = 2  # of a controller
MAX_CAMERA_IMAGE_BYTES = SLOTS * MAX_IMAGE_BYTES // (2 * MAX_CAMERAS)

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
        self._of_camera = [0] * MAX_CAMERAS

    @staticmethod
    def description(descriptor: int) -> dict[str, int]:
        """Return what a program needs to map the memory; `descriptor` is the number in the box."""
        return {"descriptor": descriptor, "bytes": SLOTS * MAX_IMAGE_BYTES}

    def put_first(self, image: object) -> bytes:
        """Store the image that a tracker starts with; return its IMAGE header."""
        return self._put(0, image, MAX_IMAGE_BYTES)

    def put_next(self, image: object) -> bytes:
        """Store an image over the last but one; return its IMAGE header."""
        self._updates += 1
        slot = 1 + self._updates % (SLOTS - 1)
        return self._put(slot * MAX_IMAGE_BYTES, image, MAX_IMAGE_BYTES)

    def put_of_camera(self, camera: int, image: object) -> bytes:
        """Store an image of a controller's camera over its last but one; return its IMAGE header.

        A box is given either these or a tracker's images.
        """
        self._of_camera[camera] += 1
        slot = 2 * camera + self._of_camera[camera] % 2
        return self._put(slot * MAX_CAMERA_IMAGE_BYTES, image, MAX_CAMERA_IMAGE_BYTES)

    def _put(self, offset: int, image: object, most_bytes: int) -> bytes:
        view = memoryview(image)  # type: ignore[arg-type]
        shape = view.shape or ()
        fits = len(shape) == 2 or (len(shape) == 3 and shape[2] == COLOURS)
        fits = fits and view.c_contiguous and 0 < view.nbytes <= most_bytes
        if view.format != "B" or not fits:
            raise ValueError(
                f"an image is C-contiguous uint8 of (H, W) or (H, W, {COLOURS}) and has at most "
                f"{most_bytes} bytes, not {view.format!r} of {shape}"
            )
        self._memory[offset : offset + view.nbytes] = view.cast("B")
        return IMAGE.pack(offset, *shape[:2], COLOURS if len(shape) == 3 else 1)

    def close(self) -> None:
        """Release the memory; a second call does nothing."""
        self._memory.close()
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

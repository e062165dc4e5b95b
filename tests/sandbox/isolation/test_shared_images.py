"""The images' memory: whoever holds its descriptor can read it, and nothing else."""

import fcntl
import mmap
import os
import subprocess
import sys
import textwrap

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.isolation.shared_images import (
    MAX_CAMERA_IMAGE_BYTES,
    MAX_CAMERAS,
    MAX_IMAGE_BYTES,
    SLOTS,
    SharedImages,
)
from seamark.sandbox.languages.inside.wire import IMAGE
from seamark.sim import registry
from seamark.sim.settings.setting import limits_of

SIZE = SLOTS * MAX_IMAGE_BYTES
ATTACKS = """
    import ctypes, fcntl, mmap, os, sys
    libc = ctypes.CDLL(None, use_errno=True)
    number = int(sys.argv[1])
    path = f"/proc/self/fd/{number}"

    def punched(descriptor):  # FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE
        if libc.fallocate(descriptor, 3, ctypes.c_long(0), ctypes.c_long(4096)):
            raise OSError("fallocate")

    def mapped(descriptor):
        mmap.mmap(descriptor, 4096, mmap.MAP_SHARED)[0] = 7

    def unprotected(descriptor):
        libc.mmap.restype = ctypes.c_void_p
        address = libc.mmap(None, 4096, 1, 1, descriptor, 0)
        if libc.mprotect(ctypes.c_void_p(address), 4096, 3):
            raise OSError("mprotect")

    def reopened():
        return os.open(path, os.O_RDWR)

    def sealed(descriptor):
        fcntl.fcntl(descriptor, 1033, 8)

    for name, attack in {
        "write": lambda: os.pwrite(number, b"x", 0),
        "truncate": lambda: os.ftruncate(number, 0),
        "extend": lambda: os.ftruncate(number, 1 << 30),
        "punch": lambda: punched(number),
        "map": lambda: mapped(number),
        "unprotect": lambda: unprotected(number),
        "seal": lambda: sealed(number),
        "reopened write": lambda: os.pwrite(reopened(), b"x", 0),
        "reopened truncate": lambda: os.ftruncate(reopened(), 0),
        "truncate by path": lambda: os.truncate(path, 0),
        "reopened punch": lambda: punched(reopened()),
        "reopened map": lambda: mapped(reopened()),
        "reopened unprotect": lambda: unprotected(reopened()),
        "reopened seal": lambda: sealed(reopened()),
    }.items():
        try:
            attack()
        except OSError:
            continue
        print(name)
"""


def test_a_process_of_the_same_user_with_the_descriptor_can_change_nothing() -> None:
    memory = SharedImages()
    memory.put_first(memoryview(bytes(4096)).cast("B", (64, 64)))
    command = [sys.executable, "-c", textwrap.dedent(ATTACKS), str(memory.descriptor)]

    done = subprocess.run(
        command, pass_fds=[memory.descriptor], capture_output=True, text=True, check=True
    )

    assert done.stdout.split("\n") == [""]
    assert os.fstat(memory.descriptor).st_size == SIZE
    assert os.pread(memory.descriptor, 4096, 0) == bytes(4096)
    memory.close()


def test_the_descriptor_that_is_handed_out_was_never_open_for_writing() -> None:
    memory = SharedImages()

    assert fcntl.fcntl(memory.descriptor, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY
    memory.close()


@given(
    images=st.lists(
        st.tuples(st.booleans(), st.integers(1, 9), st.integers(1, 9), st.sampled_from([1, 3])),
        max_size=12,
    )
)
def test_an_image_lies_where_the_message_says_and_keeps_those_that_must_stay(images) -> None:
    memory = SharedImages()
    reading = mmap.mmap(memory.descriptor, SIZE, prot=mmap.PROT_READ)
    first, updates = None, []
    for number, (starts, height, width, channels) in enumerate(images):
        shape = (height, width) if channels == 1 else (height, width, channels)
        image = bytes([number + 1]) * (height * width * channels)
        put = memory.put_first if starts else memory.put_next
        header = IMAGE.unpack(put(memoryview(image).cast("B", shape)))
        assert header[1:] == (height, width, channels)
        if starts:
            first = (header[0], image)
        else:
            updates = [*updates[-1:], (header[0], image)]
        for offset, kept in [*([first] if first else []), *updates]:
            assert reading[offset : offset + len(kept)] == kept
    reading.close()
    memory.close()


@given(
    images=st.lists(
        st.tuples(st.integers(0, MAX_CAMERAS - 1), st.integers(1, 9), st.integers(1, 9)),
        max_size=12,
    )
)
def test_an_image_of_a_camera_stays_until_the_next_but_one_of_that_camera(images) -> None:
    memory = SharedImages()
    reading = mmap.mmap(memory.descriptor, SIZE, prot=mmap.PROT_READ)
    kept: dict[int, list[tuple[int, bytes]]] = {}
    for number, (camera, height, width) in enumerate(images):
        image = bytes([number + 1]) * (height * width)
        put = memory.put_of_camera(camera, memoryview(image).cast("B", (height, width)))
        offset, *shape = IMAGE.unpack(put)
        assert shape == [height, width, 1]
        kept[camera] = [*kept.get(camera, [])[-1:], (offset, image)]
        for at, content in [one for both in kept.values() for one in both]:
            assert reading[at : at + len(content)] == content
    reading.close()
    memory.close()


def test_the_largest_image_of_a_camera_fits_and_a_larger_one_is_refused() -> None:
    fields = registry.benchmark("currents-v2").configuration.model_fields
    width, height = (
        limits_of(fields[f"camera_{side}_px"])["maximum"] for side in ("width", "height")
    )
    memory = SharedImages()
    last = MAX_CAMERAS - 1

    largest = memoryview(bytes(width * height)).cast("B", (height, width))
    for _ in range(2):
        offset, *_shape = IMAGE.unpack(memory.put_of_camera(last, largest))
        assert offset + width * height <= SIZE
    size = MAX_CAMERA_IMAGE_BYTES + 1
    with pytest.raises(ValueError, match="bytes"):
        memory.put_of_camera(0, memoryview(bytes(size)).cast("B", (1, size)))
    memory.close()


def test_closing_twice_does_nothing() -> None:
    memory = SharedImages()
    memory.close()
    memory.close()

    with pytest.raises(ValueError, match="closed"):
        memory.put_first(memoryview(bytes(4)).cast("B", (2, 2)))

"""Records of currents of users: read in another process, and known here only while lent."""

import io
import struct
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from seamark.server.programs import own_files
from seamark.server.programs.own_files import FileRejected
from seamark.server.programs.reader import ProgramReader
from seamark.sim.files import target_pictures
from seamark.sim.physics.water_motion import records
from seamark.sim.physics.water_motion.record import BYTES_MAX
from tests.cast import MARKER, RECORD, Backend

OWN_CPU_S = 0.2  # of the process that has a file read: the pipe, and the start of the next reader
LENT_CPU_S = 2.0  # 0.23 s where it was measured
HEAD = "# seamark-current 1\ntime_s,height_m,north,east,down\n"


def repeated(line: str) -> str:
    """Return as many lines as a file may have bytes."""
    return HEAD + line * ((BYTES_MAX - len(HEAD)) // len(line))


def largest() -> str:
    """Return a record with as many rows as fit."""
    lines, size, at = [HEAD], len(HEAD), 0
    while size < BYTES_MAX - 400:
        lines += [f"{at},{height},.2,0,0\n" for height in range(9)]
        size, at = size + sum(map(len, lines[-9:])), at + 1
    return "".join(lines)


HOSTILE: dict[str, tuple[Callable[[], str | bytes], str]] = {
    "too large": (lambda: RECORD + "#" * BYTES_MAX, "at most"),
    "nothing": (lambda: "", "begins with"),
    "binary": (lambda: bytes(range(256)) * 4000, "text in UTF-8"),
    "zeros": (lambda: bytes(BYTES_MAX), "begins with"),
    "not a number": (lambda: RECORD.replace(",0.05,", ",nan,"), "five numbers"),
    "infinite": (lambda: RECORD.replace(",0.05,", ",inf,"), "five numbers"),
    "an endless step": (
        lambda: HEAD + "".join(f"{1.7e307 * at},1,0.2,0,0\n" for at in range(-10, 11)),
        "equal steps",
    ),
    "many notes": (lambda: HEAD[:20] + "# a: b\n" * 200_000, "has the line"),
    "many commas": (lambda: HEAD + "," * (BYTES_MAX - 100), "five numbers"),
    "a long number": (lambda: HEAD + "1" * (BYTES_MAX - 100) + ",1,1,1,1\n", "five numbers"),
    "many equal rows": (lambda: repeated("0,0,0,0,0\n"), "instants"),
    "many empty rows": (lambda: repeated("\n"), "too many rows"),
}


@pytest.fixture(scope="module")
def reader() -> Iterator[ProgramReader]:
    with closing(ProgramReader()) as reader:
        yield reader


def read(reader: ProgramReader, content: str | bytes) -> bytes:
    content = content.encode() if isinstance(content, str) else content
    setting = records.LIBRARY.setting
    return reader.read_file(io.BytesIO(content), "my.csv", setting=setting, owner="ann")


def read_picture(reader: ProgramReader, content: bytes) -> bytes:
    setting = target_pictures.LIBRARY.setting
    return reader.read_file(io.BytesIO(content), "my.png", setting=setting, owner="ann")


def png(width: int, height: int, rows: bytes) -> bytes:
    """Return a PNG of 8 bits of grey, whose rows, compressed, may be of another size."""
    parts = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0))]
    parts += [(b"IDAT", rows), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
        for kind, body in parts
    )


def zeros(count: int) -> bytes:
    """Return that many bytes 0, compressed by a thousand."""
    packer = zlib.compressobj(9)
    chunks = [packer.compress(bytes(1 << 20)) for _ in range(count >> 20)]
    return b"".join(chunks) + packer.flush()


# Side [px] and size [byte]: a bit too large, more than a reader's memory, and what OpenCV refuses.
BOMBS = {"20 MB": (4_500, 20 << 20), "1 GB": (30_000, 901 << 20), "2^60": (1 << 30, 1 << 20)}


def test_a_record_is_read_without_being_known_here(reader: ProgramReader) -> None:
    content = read(reader, RECORD)

    assert content == RECORD.encode()
    assert not records.LIBRARY.is_known(records.LIBRARY.name_of(content))


@pytest.mark.parametrize("attack", HOSTILE)
def test_a_hostile_record_is_refused_and_costs_this_process_nothing(
    reader: ProgramReader, attack: str
) -> None:
    make, sentence = HOSTILE[attack]
    content = make()
    before = time.process_time()

    with pytest.raises(FileRejected, match=sentence) as caught:
        read(reader, content)

    assert time.process_time() - before < OWN_CPU_S
    assert caught.value.field == records.LIBRARY.setting


def test_a_picture_is_kept_as_grey_levels(reader: ProgramReader) -> None:
    content = read_picture(reader, MARKER)

    assert content == target_pictures.LIBRARY.converted(MARKER)
    assert not target_pictures.LIBRARY.is_known(target_pictures.LIBRARY.name_of(content))


@pytest.mark.parametrize("bomb", BOMBS)
def test_a_picture_that_expands_is_refused_and_costs_this_process_nothing(
    reader: ProgramReader, bomb: str
) -> None:
    side, size = BOMBS[bomb]
    content = png(side, side, zeros(size))
    before = time.process_time()

    with pytest.raises(FileRejected, match=r"can be decoded|at most 4096|too much") as caught:
        read_picture(reader, content)

    assert time.process_time() - before < OWN_CPU_S
    assert caught.value.field == "target_texture"


def test_the_largest_picture_is_read(reader: ProgramReader) -> None:
    """With the memory and the time that the process that reads it has."""
    row = b"\0" + bytes(range(256)) * 16
    content = png(4096, 4096, zlib.compress(row * 4096))

    assert target_pictures.read(read_picture(reader, content)).std() > 50.0


@pytest.mark.slow
def test_the_largest_record_that_is_accepted_is_known_within_a_moment(
    reader: ProgramReader,
) -> None:
    content = read(reader, largest())
    before = time.process_time()
    with records.LIBRARY.lending(content) as name:
        assert records.LIBRARY.is_known(name)

    assert time.process_time() - before < LENT_CPU_S


def test_a_record_that_was_changed_in_the_store_is_not_used(backend: Backend) -> None:
    record = backend.store_record()
    run = backend.show(
        backend.queue(files=(record,), config={records.LIBRARY.setting: record.name})
    )
    file = backend.settings.data / "programs" / record.sha256
    file.write_bytes(record.content.replace(b"A test", b"A tess"))

    with own_files.lent_to(backend.settings, run):
        assert not records.LIBRARY.is_known(record.name)
    assert own_files.contents_of(run, backend.settings) == {}

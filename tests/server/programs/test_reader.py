"""Uploads that attack what reads them: the process of a test stays responsive and small.

What reads them is started here as the service starts it, not forked as in other tests.
"""

import io
import threading
import time
import zipfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress

import pytest

from seamark.programs import preparation
from seamark.programs.preparation import PreparedProgram, UploadRejected
from seamark.server.programs.reader import ProgramReader
from tests.services import forked_commands

GOOD = b"class Controller(Base):\n    pass\n"
LIMIT = 8 * 2**20  # [B]
SLOW = "nested f-strings"  # takes all the CPU time that an upload may take


@pytest.fixture(scope="module")
def reader() -> Iterator[ProgramReader]:
    with forked_commands.started_anew(), closing(ProgramReader()) as reader:
        yield reader


def _read(
    reader: ProgramReader, source: bytes, name: str = "mine.py", owner: str = "ann"
) -> PreparedProgram:
    stream = io.BytesIO(source)
    return reader.read_upload(stream, name, owner=owner, limit=LIMIT, role="controller")


def _archive(files: dict[str, bytes]) -> bytes:
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return target.getvalue()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("source", "name"),
    [
        (GOOD, "mine.py"),
        (b"class Control: pass\n", "a/mine.py"),
        (b"\n\ndef f(:\n", "mine.py"),
        (b"int x;", "a.c"),
        (_archive({"main.py": GOOD, "part.py": b"x = 1\n"}), "all.zip"),
    ],
)
def test_an_upload_is_read_in_the_limited_process_as_without_it(
    reader: ProgramReader, source: bytes, name: str
) -> None:
    assert _read(reader, source, name) == preparation.prepare(source, name)


@pytest.mark.slow
def test_a_refusal_of_the_limited_process_has_its_sentence(reader: ProgramReader) -> None:
    with pytest.raises(UploadRejected, match=r"a\.py is empty"):
        _read(reader, b" ", "a.py")


def test_an_upload_too_large_is_not_read_to_its_end(reader: ProgramReader) -> None:
    stream = io.BytesIO(b"x" * 10_000_000)

    with pytest.raises(UploadRejected, match="larger than"):
        reader.read_upload(stream, "a.py", owner="ann", limit=1000, role="controller")

    assert stream.tell() < 200_000


HOSTILE: dict[str, tuple[str, Callable[[], bytes]]] = {
    SLOW: ("a.py", lambda: b"f'" + b"{1}" * 170_000 + b"'\n"),
    "a memory bomb": ("a.py", lambda: b"[" + b"-1," * 170_000 + b"]\n"),
    "deep nesting": ("a.py", lambda: b"x = " + b"-" * 500_000 + b"1\n"),
    "many files in an archive": (
        "a.zip",
        lambda: _archive({f"m{i}.py": b"f'" + b"{1}" * 2000 + b"'\n" for i in range(250)}),
    ),
    "a zip bomb": ("a.zip", lambda: _archive({"main.py": b"\0" * (64 << 20)})),
    "an FMU with a billion laughs": (
        "a.fmu",
        lambda: _archive(
            {
                "modelDescription.xml": b'<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa">'
                + b"".join(
                    b'<!ENTITY b%d "%s">' % (i, b"&b%d;" % (i - 1) * 10 if i else b"&a;" * 10)
                    for i in range(9)
                )
                + b"]><x>&b8;</x>"
            }
        ),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("attack", [name for name in HOSTILE if name != SLOW])
def test_no_upload_occupies_the_process_that_received_it(
    reader: ProgramReader, attack: str
) -> None:
    name, make = HOSTILE[attack]

    with _responsive(), suppress(UploadRejected):
        _read(reader, make(), name)


@pytest.mark.slow
def test_an_upload_that_takes_too_long_occupies_nothing_is_refused_and_the_next_one_read(
    reader: ProgramReader,
) -> None:
    name, make = HOSTILE[SLOW]

    with (
        _responsive(),
        pytest.raises(UploadRejected, match=r"a\.py: reading it takes too much time or memory"),
    ):
        _read(reader, make(), name)

    assert _read(reader, GOOD).content == GOOD


@contextmanager
def _responsive() -> Iterator[None]:
    """Fail if what is done meanwhile stops another thread of this process or takes its time."""
    longest, ended = [0.0], threading.Event()

    def beat() -> None:  # a page that another thread serves meanwhile
        while not ended.is_set():
            begin = time.monotonic()
            ended.wait(0.01)
            longest[0] = max(longest[0], time.monotonic() - begin)

    begin = time.process_time()
    with ThreadPoolExecutor(1) as pages:
        beating = pages.submit(beat)
        try:
            yield
        finally:
            ended.set()
        beating.result()

    assert longest[0] < 1.0
    assert time.process_time() - begin < 1.0


@pytest.mark.slow
def test_uploads_of_several_threads_get_their_own_answers(reader: ProgramReader) -> None:
    sources = {f"user{number}": GOOD + b"# %d\n" % number for number in range(12)}

    with ThreadPoolExecutor(6) as threads:
        read = threads.map(
            lambda owner: _read(reader, sources[owner], owner=owner).content, sources
        )

    assert list(read) == list(sources.values())

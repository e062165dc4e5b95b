"""Programs that come with a language: to start from, and to test with."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

LONG_AGO = (1980, 1, 1, 0, 0, 0)  # so that the bytes of an archive do not change


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """One program, in files beside its language."""

    files: Mapping[str, Path]  # name -> file; the first one is uploaded, or all as an archive
    archive: str = ""  # the name of the archive that is uploaded
    role: str = "controller"
    moves_arm: bool = False  # whether it is for benchmarks whose programs move an arm
    name: str = ""  # of a second starter in the same language, for `seamark init --language`
    heading: str = ""  # above its text in the documentation; empty: "Starter in <language>"
    build: str = ""  # the user's command that makes an upload of {source}: {program}

    @property
    def upload_name(self) -> str:
        """Return the name of the file that is uploaded."""
        return self.archive or next(iter(self.files))

    def contents(self) -> dict[str, bytes]:
        """Return the files; the one that is uploaded or compiled comes first."""
        files = {name: path.read_bytes() for name, path in self.files.items()}
        return {self.archive: _zipped(files), **files} if self.archive else files

    def upload(self) -> bytes:
        """Return the file that is uploaded."""
        return self.contents()[self.upload_name]

    @property
    def companions(self) -> Mapping[str, Path]:
        """The texts that its author needs beside it; none if all files are one archive."""
        return {} if self.archive else dict([*self.files.items()][1:])

    def text(self) -> str:
        """Return the text of the first file."""
        return next(iter(self.files.values())).read_text("utf-8")


def sample(path: Path, *companions: Path, role: str = "controller") -> Sample:
    """Return a program of one text, with files that its author needs beside it."""
    files = {file.name: file for file in (path, *companions)}
    return Sample(files=files, role=role)


def _zipped(files: Mapping[str, bytes]) -> bytes:
    import io  # noqa: PLC0415  (5 ms that most commands can save)
    import zipfile  # noqa: PLC0415

    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(zipfile.ZipInfo(name, LONG_AGO), content)
    return whole.getvalue()

"""What an upload has to be: checked and brought into normal form, never run.

The work on content that nobody trusts takes place in a limited process (`reader_process`): parsing
Python is quadratic in some sources, and an archive expands.
"""

from dataclasses import dataclass, replace
from itertools import zip_longest

from seamark.programs import archives, declarations, file_types, matlab_lint, python_lint
from seamark.programs.archives import ArchiveRefused
from seamark.programs.diagnostics import Diagnostic
from seamark.programs.parameters import Parameter
from seamark.sandbox.languages import LANGUAGES, language_of
from seamark.sandbox.languages.matlab import MATLAB
from seamark.sandbox.languages.python import PYTHON
from seamark.sandbox.limits import Limits
from seamark.sandbox.printable_text import visible_text

# what can be checked without running a program
LINTERS = {PYTHON.name: python_lint.lint, MATLAB.name: matlab_lint.lint}
NAME_MAX = 120  # [character] of a file name, from its end
TEXT_MAX_BYTES = 2 * 2**20  # of a source file; archives may be larger
_LIMITS = Limits()


class UploadRejected(Exception):
    """The upload breaks a rule. The text is for the user and shown on the form, at `field`."""

    field = "program"


class UploadTooLarge(UploadRejected):
    """The upload is larger than a program of its type may be."""


@dataclass(frozen=True, slots=True)
class PreparedProgram:
    """An upload in normal form, with the problems found in its source."""

    name: str
    language: str
    content: bytes  # source text, or a plain zip archive (see seamark.programs.archives)
    diagnostics: tuple[Diagnostic, ...] = ()
    parameters: tuple[Parameter, ...] = ()  # that it declares

    def require_clean(self) -> None:
        """Raise UploadRejected with the first problems if there are any."""
        if self.diagnostics:
            raise UploadRejected(" ".join(_as_sentence(one) for one in self.diagnostics[:3]))


def prepare(source: bytes, filename: str, *, role: str = "controller") -> PreparedProgram:
    """Return a program in normal form. Runs nothing of it; raises UploadRejected.

    Parameters
    ----------
    role
        What the benchmark evaluates: a key of `seamark.programs.interfaces.INTERFACES`.
    """
    name = clean_name(filename)
    language = language_by_suffix(name)
    if not source.strip():
        raise UploadRejected(f"{name} is empty.")
    if language is None or LANGUAGES[language].is_archive:
        return _prepare_archive(source, name, language, role)
    _check_format(name, source, language)
    diagnostics = _lint(language, {name: source}, name, role)
    return _declaring(PreparedProgram(name, language, source, diagnostics), source, name)


def clean_name(filename: str) -> str:
    """Return the last part of a client's file name, without control characters."""
    last = filename[-4 * NAME_MAX :].replace("\\", "/").rsplit("/", 1)[-1]
    name = visible_text(last).strip()[-NAME_MAX:]
    if not name.strip("."):
        raise UploadRejected("The file has no name.")
    return name


def language_by_suffix(name: str) -> str | None:
    """Return the language; None for an archive, where the main file decides."""
    language = language_of(name)
    if language is None and not archives.is_archive(name):
        raise UploadRejected(file_types.refusal(name))
    return language


def _prepare_archive(source: bytes, name: str, language: str | None, role: str) -> PreparedProgram:
    try:
        files = archives.files_of(source, name, limits=_LIMITS)
        content = archives.normal_form(files, limits=_LIMITS)
    except ArchiveRefused as reason:
        raise UploadRejected(f"{name}: {reason}") from None
    if language is not None:
        return _declaring(PreparedProgram(name, language, content), content, name)
    language, main = _main_file(files, name)
    diagnostics = _lint(language, files, main, role)
    return _declaring(PreparedProgram(name, language, content, diagnostics), files[main], main)


def _declaring(prepared: PreparedProgram, source: bytes, main: str) -> PreparedProgram:
    """Return the program with the parameters that its main file declares."""
    declared = declarations.read(prepared.language, source, main)
    return replace(
        prepared,
        diagnostics=(*prepared.diagnostics, *declared.diagnostics),
        parameters=tuple(declared.parameters),
    )


def _lint(language: str, files: dict[str, bytes], main: str, role: str) -> tuple[Diagnostic, ...]:
    """Return what the language's linter finds, nothing if it has none."""
    return tuple(LINTERS[language](files, main, role)) if language in LINTERS else ()


def _main_file(files: dict[str, bytes], name: str) -> tuple[str, str]:
    """Return language and path of the archive's main file.

    The first names of all languages come before their second ones: a program in C may have a
    `controller.py` beside it that tries it.
    """
    languages = LANGUAGES.values()
    ranked = zip_longest(*([(main, one) for main in one.archive_mains] for one in languages))
    mains = [found for rank in ranked for found in rank if found is not None]
    for main, language in mains:
        if main in files:
            return language.name, main
    known = ", ".join(f"{main} ({one.label})" for one in languages for main in one.archive_mains)
    top = sorted(path for path in files if "/" not in path)[:5]
    raise UploadRejected(
        f"{name}: the archive needs one of {known} at its top level; it has "
        f"{', '.join(top) or 'only folders'}."
    )


def _check_format(name: str, source: bytes, language: str) -> None:
    """Raise UploadRejected if these bytes cannot be a program of this language."""
    known = LANGUAGES[language]
    if known.is_text and not known.states_encoding:
        _check_utf8(name, source)
    elif known.binary_refusal and (reason := known.binary_refusal(source)):
        raise UploadRejected(f"{name}: {reason}")


def _check_utf8(name: str, source: bytes) -> None:
    try:
        source.decode("utf-8")
    except UnicodeDecodeError as error:
        line = source[: error.start].count(b"\n") + 1
        raise UploadRejected(f"{name}, line {line}: the source is not UTF-8.") from None


def _as_sentence(diagnostic: Diagnostic) -> str:
    file = str(diagnostic.file)
    location = f"{file}, line {diagnostic.line}" if diagnostic.line else file
    return f"{location}: {diagnostic.sentence}"

"""What the service needs to know about a programming language."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

from seamark.sandbox.languages.sample import Sample
from seamark.sandbox.runtime import Runtime

CONTROLLER, TRACKER, DETECTOR = "controller", "tracker", "detector"
ALL_ROLES = (CONTROLLER, TRACKER, DETECTOR)


class Declarations(StrEnum):
    """How a program declares its parameters (docs/languages.md)."""

    NONE = "none"
    LITERAL = "literal"  # `PARAMETERS = {...}` in Python
    COMMENTS = "comments"  # lines with `@parameter` behind //, /*, % or #
    MODEL = "model"  # the model description of an FMU


@dataclass(frozen=True, slots=True)
class Calls:
    """How the calls of a program are named in the message about a timeout."""

    start: str
    reset: str
    step: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Language:
    """One language: all that differs between languages is in its object.

    If it has a `compiler`, what runs is not the upload but what the compiler made of it, in its own
    box (see sandbox/compilation.py).
    """

    name: str  # in the database and on the command line
    label: str
    suffixes: tuple[str, ...]
    runtime: Callable[[], Runtime]  # looks at the host at its first call; SandboxBroken if missing
    calls: Calls
    self_test: Sample  # the expected answers are in sandbox/probing/self_test.py
    starters: tuple[Sample, ...]  # programs to start from
    conformance: tuple[Sample, ...]  # the law of the built-in PI; the tracker of starter/tracker.c
    compiler: Callable[[], Runtime] | None = None
    archive_mains: tuple[str, ...] = ()  # an archive with one of these is of this language
    is_archive: bool = False  # its files are zip archives
    roles: tuple[str, ...] = (CONTROLLER,)  # what its programs can be
    binary_refusal: Callable[[bytes], str] | None = None  # for files that are no text: why not
    samples_compiled_by: str = ""  # the language whose compiler builds the samples, if not its own
    debian_packages: tuple[str, ...] = ()  # beside what Seamark installs itself
    noun: str = ""  # what its programs are in words, if they are not written in it: "an FMU"
    syntax: str = ""  # of its first starter, as Pygments and the form's editor name it
    declarations: Declarations = Declarations.NONE
    sets_by_name: bool = False  # parameters with the name of a setting are set by the setting
    states_encoding: bool = False  # a source says itself how it is encoded; else it is UTF-8
    in_the_box: str = ""  # what its programs find there, in Markdown, for the page "In the box"

    @property
    def file_name(self) -> str:
        """What its programs are called in every box: the user's own name could tell them something.

        A name is no part of what is submitted, so the same submission could behave differently.
        """
        return f"program{self.suffixes[0]}"

    @property
    def gets_images(self) -> bool:
        """Whether its programs can be given images: it can have a role that needs them."""
        return self.roles != (CONTROLLER,)

    @property
    def short_label(self) -> str:
        """The label without what is in brackets."""
        return self.label.partition(" (")[0]

    @property
    def described(self) -> str:
        """What one of its programs is, such as "Python" or "an FMU"."""
        return self.noun or self.short_label

    @property
    def is_text(self) -> bool:
        """Whether its files are texts that people write."""
        return not self.is_archive and self.binary_refusal is None

    @property
    def runs_binaries(self) -> bool:
        """Whether its boxes run compiled programs."""
        return self.compiler is not None or self.binary_refusal is not None

    @property
    def sample_compiler(self) -> str:
        """The language whose compiler builds the self-test and the conformance programs."""
        return self.samples_compiled_by or self.name

    @property
    def remedy(self) -> str:
        """What to do if its self-test does not pass."""
        if not self.debian_packages:
            return "`./run` installs all that it needs"
        return f"apt-get install {' '.join(self.debian_packages)}"

    def starter(self, role: str = CONTROLLER, *, moves_arm: bool = False) -> Sample | None:
        """Return the program to start from; None if there is none for this role."""
        matching = (
            one
            for one in self.starters
            if one.role == role and one.moves_arm == moves_arm and not one.name
        )
        return next(matching, None)

"""What to upload instead of a file that is no program."""

from pathlib import PurePosixPath

from seamark.programs.archives import SUFFIXES
from seamark.sandbox.languages import LANGUAGES

_HEADER = "A header goes into an archive with the program that includes it."
_MODEL = (
    "Simulink does not run in the sandbox. Export the model as an FMU and upload the .fmu file, or "
    "generate C with Embedded Coder and upload an archive of the generated files."
)
_NETWORK = "Put the network into an archive with a main.py that runs it."
_INSTEAD = {
    ".ipynb": "Export the notebook as a script (.py) first.",
    ".slx": _MODEL,
    ".mdl": _MODEL,
    ".mlx": "Save the live script as a plain .m file.",
    ".p": "MATLAB's encrypted files cannot be read; upload the .m file.",
    ".onnx": _NETWORK,
    ".pt": "PyTorch is not available in the sandbox. Export the network to ONNX. " + _NETWORK,
    ".pth": "PyTorch is not available in the sandbox. Export the network to ONNX. " + _NETWORK,
    ".h5": "Keras is not available in the sandbox. Export the network to ONNX. " + _NETWORK,
    ".h": _HEADER,
    ".hpp": _HEADER,
    ".pyc": "Upload the source (.py).",
    ".exe": "Executables have to be for 64-bit Linux.",
    ".rs": "Compile it for 64-bit Linux and upload the executable.",
    ".go": "Compile it for 64-bit Linux and upload the executable.",
}


def packed() -> tuple[str, ...]:
    """Return the endings of uploads that are archives, and so no texts."""
    languages = (language for language in LANGUAGES.values() if language.is_archive)
    return (*SUFFIXES, *(suffix for language in languages for suffix in language.suffixes))


def refusal(name: str) -> str:
    """Return why a file of this name cannot be a program, and which ones can."""
    suffix = PurePosixPath(name).suffix.lower()
    types = ", ".join(
        f"{' or '.join(filter(None, language.suffixes))} ({language.short_label})"
        for language in LANGUAGES.values()
        if language.binary_refusal is None
    )
    instead = _INSTEAD.get(suffix, "Rename the file if it is one of these.")
    return (
        f"{name}: {suffix} is not a type of program. {instead} Programs end in {types}, archives "
        f"in {' or '.join(SUFFIXES)}; executables for Linux have no suffix."
    )

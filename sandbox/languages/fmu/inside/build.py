"""How an FMU of sources is compiled: as modelDescription.xml or buildDescription.xml say, or all.

Whatever is not supported of buildDescription.xml (FMI 3.0) is refused, not ignored: a model that is
compiled in another way may be another model.
"""

import re
from pathlib import PurePosixPath
from typing import NamedTuple
from xml.etree import ElementTree

from .description import PLATFORMS, Description, Unusable

BUILD = "sources/buildDescription.xml"
WORD = re.compile(r"[A-Za-z_]\w*", re.ASCII)
UNSUPPORTED = "the sandbox compiles with GCC and its own options, and links only the C library"


class Build(NamedTuple):
    """What the compiler is given beside its own command line."""

    sources: list[str]  # members of the archive
    options: list[str]


def build_of(description: Description) -> Build:
    """Return sources and options; no sources if the FMU has none; Unusable with the reason."""
    members = set(description.archive.namelist())
    if description.version == "3" and BUILD in members:
        return _described(description, members)
    listed = [f"sources/{name}" for name in description.sources]
    sources = listed or sorted(name for name in members if name.startswith("sources/"))
    return Build([name for name in sources if name in members and name.endswith(".c")], [])


def _described(description: Description, members: set[str]) -> Build:
    try:
        root = ElementTree.fromstring(description.archive.read(BUILD))  # noqa: S314  (in the box)
    except ElementTree.ParseError as error:
        raise Unusable(f"{BUILD} is not XML: {error}.") from None
    for configuration in root.iterfind("BuildConfiguration"):
        if configuration.get("modelIdentifier") != description.identifier:
            continue
        if configuration.get("platform", PLATFORMS["3"]) == PLATFORMS["3"]:
            return _configured(configuration, members)
    raise Unusable(
        f"{BUILD} has no BuildConfiguration for {description.identifier} on {PLATFORMS['3']}."
    )


def _configured(configuration: ElementTree.Element, members: set[str]) -> Build:
    libraries = [str(one.get("name")) for one in configuration.iterfind("Library")]
    if libraries:
        raise Unusable(f"{BUILD} asks for the libraries {', '.join(libraries)}; {UNSUPPORTED}.")
    build = Build([], [])
    for files in configuration.iterfind("SourceFileSet"):
        language, options = files.get("language", "C"), files.get("compilerOptions", "")
        if options or not re.fullmatch(r"C(\d\d)?", language):
            raise Unusable(f"{BUILD} asks for {language} {options or 'sources'}; {UNSUPPORTED}.")
        for one in files.iterfind("SourceFile"):
            build.sources.append(_member(one, members))
        build.options.extend(map(_definition, files.iterfind("PreprocessorDefinition")))
        build.options.extend(f"-I{_inside(one)}" for one in files.iterfind("IncludeDirectory"))
    return build


def _member(one: ElementTree.Element, members: set[str]) -> str:
    name = _inside(one)
    if name not in members:
        raise Unusable(f"{BUILD} names {name}, which is not in the FMU.")
    return name


def _inside(one: ElementTree.Element) -> str:
    path = PurePosixPath("sources", one.get("name", ""))
    if ".." in path.parts or path.parts[0] != "sources":
        raise Unusable(f"{BUILD} names {one.get('name')}, which is outside its folder.")
    return str(path)


def _definition(one: ElementTree.Element) -> str:
    name, value = one.get("name", ""), one.get("value")
    if not WORD.fullmatch(name):
        raise Unusable(f"{BUILD} defines {name!r}, which is not a valid name.")
    return f"-D{name}" if value is None else f"-D{name}={value}"

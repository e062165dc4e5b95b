"""The model description of an FMU (modelDescription.xml), as FMI 2.0 and 3.0 define it.

Read only inside the box: archive and text are not trusted.
"""

import io
import json
import zipfile
import zlib
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

DESCRIPTION = "modelDescription.xml"
PLATFORMS = {"2": "linux64", "3": "x86_64-linux"}
MAPPINGS = ("extra/seamark.json", "resources/seamark.json")
TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}  # FMI 2.0: FMI 3.0


class Unusable(Exception):
    """This FMU cannot be a controller here. The text is for its owner."""


@dataclass(frozen=True, slots=True)
class Variable:
    """One variable of the model."""

    name: str
    reference: int
    type: str  # as FMI 3.0 names the types
    causality: str
    count: int  # 1, or the size of an array
    attributes: dict[str, str]  # all of its XML element, such as start, min, max and unit


@dataclass(slots=True)
class Description:
    """The parts of a model description that are needed, and the archive."""

    version: str  # "2" or "3"
    identifier: str
    token: str  # guid or instantiationToken
    variables: dict[str, Variable]
    archive: zipfile.ZipFile
    sources: list[str] = field(default_factory=list)

    @property
    def library(self) -> str:
        """Return the archive member with the binary for this platform."""
        return f"binaries/{PLATFORMS[self.version]}/{self.identifier}.so"

    @property
    def platforms(self) -> list[str]:
        """Return the platforms for which it has binaries."""
        members = (name.split("/") for name in self.archive.namelist())
        return sorted({parts[1] for parts in members if parts[0] == "binaries" and len(parts) > 2})

    def of(self, causality: str) -> list[Variable]:
        """Return the variables of one causality."""
        return [one for one in self.variables.values() if one.causality == causality]

    def mapping(self) -> dict[str, Any]:
        """Return the mapping file, empty if there is none."""
        for name in MAPPINGS:
            if name in self.archive.namelist():
                return _mapping(self.archive.read(name), name)
        return {}


def read(data: bytes) -> Description:
    """Return the description of an FMU; Unusable with a sentence if it cannot be one."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(data))
        text = archive.read(DESCRIPTION)
    except KeyError:
        raise Unusable(f"The archive has no {DESCRIPTION} in its topmost folder.") from None
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError) as error:
        raise Unusable(f"An FMU is a zip archive, and this is not one: {error}.") from None
    try:
        root = ElementTree.fromstring(text)  # noqa: S314  (a box contains the damage)
    except ElementTree.ParseError as error:
        raise Unusable(f"{DESCRIPTION} is not XML: {error}.") from None
    version = root.get("fmiVersion", "")
    if version[:1] not in PLATFORMS:
        raise Unusable(f"The FMU is of FMI {version or '?'}; FMI 2.0 and 3.0 are supported.")
    model = root.find("CoSimulation")
    if model is None or not model.get("modelIdentifier"):
        raise Unusable("The FMU has no CoSimulation part: export it for co-simulation.")
    token = root.get("guid" if version[0] == "2" else "instantiationToken", "")
    variables = _variables_2(root) if version[0] == "2" else _variables_3(root)
    whole = Description(version[0], model.get("modelIdentifier", ""), token, variables, archive)
    whole.sources = [file.get("name", "") for file in model.iterfind("SourceFiles/File")]
    return whole


def _variables_2(root: ElementTree.Element) -> dict[str, Variable]:
    variables = {}
    for one in root.iterfind("ModelVariables/ScalarVariable"):
        typed = next((child for child in one if child.tag in TYPES), None)
        type_name = "other" if typed is None else TYPES[typed.tag]
        attributes = {} if typed is None else typed.attrib
        variables[one.get("name", "")] = _variable(one, type_name, 1, attributes)
    return variables


def _variables_3(root: ElementTree.Element) -> dict[str, Variable]:
    variables = {}
    for one in root.iterfind("ModelVariables/*"):
        count = 1
        for dimension in one.iterfind("Dimension"):
            count *= int(dimension.get("start", "0"))  # 0: its size is not fixed
        variables[one.get("name", "")] = _variable(one, one.tag, count, {})
    return variables


def _variable(
    one: ElementTree.Element, type_name: str, count: int, attributes: dict[str, str]
) -> Variable:
    name, reference = one.get("name", ""), one.get("valueReference", "")
    if not reference.isdecimal():
        raise Unusable(f"The variable {name} has no integer valueReference.")
    causality = one.get("causality", "local")
    return Variable(name, int(reference), type_name, causality, count, attributes | one.attrib)


def _mapping(data: bytes, name: str) -> dict[str, Any]:
    try:
        mapping = json.loads(data)
    except ValueError as error:
        raise Unusable(f"{name} is not JSON: {error}.") from None
    parts = ("inputs", "outputs", "parameters")
    if not isinstance(mapping, dict) or any(
        key not in parts or not isinstance(value, dict) for key, value in mapping.items()
    ):
        raise Unusable(f"{name} must be an object with the objects {', '.join(parts)}.")
    return mapping


def checked(description: Description, filename: str) -> Description:
    """Return the description if there is a binary for this platform."""
    if description.library in description.archive.namelist():
        return description
    has = ", ".join(description.platforms) or "none"
    raise Unusable(
        f"{filename} has no {description.library} and no sources (platforms: {has}). Export it for "
        "64-bit Linux, or with its source code."
    )

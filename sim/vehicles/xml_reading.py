"""XML that may come from anybody: no entities; size, depth and number of elements are bounded."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

BYTES_MAX = 2 * 2**20
DEPTH_MAX = 32
ELEMENTS_MAX = 20_000
TEXT_MAX = 1000  # characters of an attribute


class XmlRefused(Exception):
    """It is not XML, or more of it than is read. The text is for the user."""


@dataclass(slots=True)
class Element:
    """An element with its attributes and children; text is left out."""

    name: str
    attributes: dict[str, str]
    children: list["Element"] = field(default_factory=list)

    def all(self, name: str) -> Iterator["Element"]:
        """Yield the children of that name."""
        return (child for child in self.children if child.name == name)

    def first(self, name: str) -> "Element | None":
        """Return the first child of that name."""
        return next(self.all(name), None)


def read_xml(content: bytes) -> Element:
    """Return the root.

    Raises
    ------
    XmlRefused
        It is not well formed, declares a document type, or exceeds a limit.
    """
    if len(content) > BYTES_MAX:
        raise XmlRefused(f"The file has {len(content)} bytes; at most {BYTES_MAX} are read.")
    builder = _Builder()
    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = builder.refuse_doctype
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        raise XmlRefused(f"The file is not valid XML: {error}.") from None
    return builder.top.children[0]


class _Builder:
    def __init__(self) -> None:
        self.top = Element("", {})
        self._open = [self.top]
        self._count = 0

    def refuse_doctype(self, *_: object) -> None:
        raise XmlRefused("The file declares a document type (<!DOCTYPE>): remove it.")

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > ELEMENTS_MAX:
            raise XmlRefused(f"The file has more than {ELEMENTS_MAX} elements.")
        if len(self._open) > DEPTH_MAX:
            raise XmlRefused(f"The file nests more than {DEPTH_MAX} elements in each other.")
        if any(len(value) > TEXT_MAX for value in attributes.values()):
            raise XmlRefused(f"An attribute of <{name[:40]}> exceeds {TEXT_MAX} characters.")
        element = Element(name, attributes)
        self._open[-1].children.append(element)
        self._open.append(element)

    def end(self, _name: str) -> None:
        self._open.pop()

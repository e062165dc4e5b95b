"""Loads compiled code without the LLVM code that it was made of, until that is needed.

Numba stores both: machine code, and LLVM code to build a function into others that are compiled
later. Where all is compiled only the first is of use, and reading the second took a seventh of the
time until a process can simulate. `compiled_cache` calls `install` before anything is loaded.
"""

import importlib
import struct
from collections.abc import Callable, Iterator
from typing import Any

BITCODE_INTERNALS = (
    "numba.core.codegen:CPUCodeLibrary._unserialize",
    "numba.core.codegen:CPUCodeLibrary._get_module_for_linking",  # reads `_shared_module`
    "numba.core.codegen:CPUCodeLibrary._finalize_final_module",
    "numba.core.codegen:CPUCodeLibrary._set_compiled_object",
    "numba.core.codegen:JitEngine.is_symbol_defined",  # reads `_defined_symbols`
)
ELF = b"\x7fELF\x02\x01"  # of 64 bits, little-endian
_HEADER = struct.Struct("<40xQ10xHH2x")  # where the table of sections is, size and number of rows
_SECTION = struct.Struct("<4xI16xQQI20x")  # type, offset, size, number of the section of the names
_SYMBOL = struct.Struct("<I2xH16x")  # offset of the name, section
_SYMBOLS = 2  # type of a section
_UNDEFINED = 0  # section of a symbol that is in another file


class LateModule:
    """The attribute `_shared_module` of a library, which may hold bitcode until it is read."""

    def __init__(self, parse: Callable[[bytes], object]) -> None:
        self._parse = parse

    def __get__(self, library: Any, _owner: object = None) -> object:
        """Return the module, or None if there is none yet."""
        module = vars(library)["_shared_module"]
        if isinstance(module, bytes):
            module = vars(library)["_shared_module"] = self._parse(module)
        return module

    def __set__(self, library: Any, module: object) -> None:
        """Keep a module or its bitcode."""
        vars(library)["_shared_module"] = module


def install() -> None:
    """Let Numba load what is compiled in this way from now on."""
    codegen: Any = importlib.import_module("numba.core.codegen")
    loaded = codegen.CPUCodeLibrary._unserialize.__func__

    def unserialize(cls: Any, own_codegen: Any, state: tuple[str, str, Any]) -> object:
        name, kind, data = state
        if kind != "object" or not data[0].startswith(ELF):
            return loaded(cls, own_codegen, state)
        code, bitcode = data
        library = own_codegen.create_library(name)
        library.enable_object_caching()
        library._set_compiled_object(code)
        library._shared_module = bitcode
        library._finalize_final_module()
        own_codegen._engine._defined_symbols.update(symbols(code))
        return library

    codegen.CPUCodeLibrary._shared_module = LateModule(codegen.ll.parse_bitcode)
    codegen.CPUCodeLibrary._unserialize = classmethod(unserialize)


def symbols(elf: bytes) -> Iterator[str]:
    """Yield the names that a file of machine code defines."""
    table, size, count = _HEADER.unpack_from(elf)
    sections = [_SECTION.unpack_from(elf, table + size * row) for row in range(count)]
    for kind, start, length, names in sections:
        if kind != _SYMBOLS:
            continue
        text = sections[names][1]
        for name, section in _SYMBOL.iter_unpack(elf[start : start + length]):
            if name and section != _UNDEFINED:
                yield elf[text + name : elf.index(b"\0", text + name)].decode()

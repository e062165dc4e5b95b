"""Files that only look like vehicles, for whoever reads those of strangers."""

from collections.abc import Callable

from seamark.sim.vehicles.toml_reading import BYTES_MAX


def lines(line: Callable[[int], str]) -> str:
    """Return as many lines as a file may have bytes."""
    text = "\n".join(line(number) for number in range(BYTES_MAX // len(line(0))))
    return text[: text.rindex("\n", 0, BYTES_MAX)]


HOSTILE: dict[str, str | bytes] = {
    "too large": b"#" * (BYTES_MAX + 1),
    "a million entries": "\n".join(f"a{n}=1" for n in range(1_000_000)),
    "many entries": lines(lambda n: f"a{n}=1"),
    "many tables": lines(lambda n: f"[a{n}]"),
    "many lists of tables": lines(lambda n: f"[[thrusters]]#{n}"),
    "many values": "a = [\n" + "1,\n" * 60_000 + "]",
    "nested lists": "a = " + "[" * 900 + "]" * 900,
    "nested lists in lines": "a = " + "[\n" * 50_000 + "]\n" * 50_000,
    "nested tables": "a = " + "{b = " * 300 + "1" + "}" * 300,
    "a long key": ".".join("a" * 900) + " = 1",
    "a long header, many keys": "[" + ".".join("a" * 900) + "]\n" + lines(lambda n: f"b{n}=1"),
    "a long key in a table": "a = {" + ".".join("a" * 900) + " = 1}",
    "a long line": "a = " + "[1]," * 10_000,
    "three quotes": 'a = """\n' * 20_000,
    "open quotes": 'a = "' + "x" * 1000,
    "a bracket in a text": 'a = "' + "[" * 1900 + '"',
    "not UTF-8": b'title = "\xff\xfe"',
    "a NUL": b"title = \x00",
    "nothing": b"",
    "a key twice": "format = 1\nformat = 1",
    "a date": "format = 1979-05-27",
    "hexadecimal": f"format = 0x{'f' * 1900}",
    "lists for tables": "body = []\nthrust = 1\nthrusters = {}\nhull = [1]\nsources = 2\n",
    "a long source": 'format = 1\n[sources]\n"' + "x" * 1900 + '" = "y"',
}

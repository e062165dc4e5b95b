"""Files that only look like vehicles, for whoever reads those of strangers."""

from collections.abc import Callable

from seamark.sim.vehicles.toml_reading import BYTES_MAX


def lines(line: Callable[[int], str]) -> str:
    """Return as many lines as a file may have bytes."""
    text = "\n".join(line(number) for number in range(BYTES_MAX // len(line(0))))
    return text[: text.rindex("\n", 0, BYTES_MAX)]


# Made when they are needed: some take longer than a module takes to load.
HOSTILE: dict[str, Callable[[], str | bytes]] = {
    "too large": lambda: b"#" * (BYTES_MAX + 1),
    "a million entries": lambda: "\n".join(f"a{n}=1" for n in range(1_000_000)),
    "many entries": lambda: lines(lambda n: f"a{n}=1"),
    "many tables": lambda: lines(lambda n: f"[a{n}]"),
    "many lists of tables": lambda: lines(lambda n: f"[[thrusters]]#{n}"),
    "many values": lambda: "a = [\n" + "1,\n" * 60_000 + "]",
    "nested lists": lambda: "a = " + "[" * 900 + "]" * 900,
    "nested lists in lines": lambda: "a = " + "[\n" * 50_000 + "]\n" * 50_000,
    "nested tables": lambda: "a = " + "{b = " * 300 + "1" + "}" * 300,
    "a long key": lambda: ".".join("a" * 900) + " = 1",
    "a long header, many keys": lambda: (
        "[" + ".".join("a" * 900) + "]\n" + lines(lambda n: f"b{n}=1")
    ),
    "a long key in a table": lambda: "a = {" + ".".join("a" * 900) + " = 1}",
    "a long line": lambda: "a = " + "[1]," * 10_000,
    "three quotes": lambda: 'a = """\n' * 20_000,
    "open quotes": lambda: 'a = "' + "x" * 1000,
    "a bracket in a text": lambda: 'a = "' + "[" * 1900 + '"',
    "not UTF-8": lambda: b'title = "\xff\xfe"',
    "a NUL": lambda: b"title = \x00",
    "nothing": lambda: b"",
    "a key twice": lambda: "format = 1\nformat = 1",
    "a date": lambda: "format = 1979-05-27",
    "hexadecimal": lambda: f"format = 0x{'f' * 1900}",
    "lists for tables": lambda: "body = []\nthrust = 1\nthrusters = {}\nhull = [1]\nsources = 2\n",
    "a long source": lambda: 'format = 1\n[sources]\n"' + "x" * 1900 + '" = "y"',
}

"""docs/protocol.md and seamark.h agree with the code.

`python -m tests.sandbox.protocol.test_protocol_page` rewrites the page's table.
"""

import re
import struct
from pathlib import Path

from seamark.sandbox.languages import c_family
from seamark.sandbox.languages.inside.wire import MAX_JOINTS, MAX_MESSAGE_BYTES, VERSION
from seamark.sandbox.protocol import messages
from seamark.sim.control import observation
from seamark.sim.control.observation import PER_FEELER, PER_MOTOR, PER_THRUSTER
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import load

PAGE = Path(__file__).parents[3] / "docs" / "protocol.md"
HEADER = Path(c_family.__file__).with_name("seamark.h")
RUNNER = Path(c_family.__file__).with_name("runner.c")
TABLE = re.compile(r"(<!-- observation: .*? -->\n)(.*?)(<!-- end -->)", re.DOTALL)
ADDED = ("thrusters", "joints_count")  # the header's own fields: how long arrays are
MOST_THRUSTERS = 8  # of a native program: the size of the header's array
LETTERS = {PER_THRUSTER: "n", PER_MOTOR: "a", PER_FEELER: "f"}
SIZES = {PER_THRUSTER: MOST_THRUSTERS, PER_MOTOR: MAX_JOINTS, PER_FEELER: MAX_JOINTS}
FIELDS = observation.EVERY_FIELD


def table() -> str:
    rows = ["| name | count | unit | meaning |", "|---|---|---|---|"]
    rows += [
        f"| `{name}` | {LETTERS.get(count, count)} "
        f"| {unit or ('boolean' if name in observation.BOOLEANS else '')} | {meaning} |"
        for name, count, unit, meaning in FIELDS
    ]
    return "\n".join(rows) + "\n"


def test_the_table_of_the_page_is_that_of_the_simulator() -> None:
    found = TABLE.search(PAGE.read_text(encoding="utf-8"))

    assert found is not None
    assert found[2] == table()


def test_every_message_type_is_on_the_page_and_no_other() -> None:
    kinds = set(re.findall(r"^\| `(\w)` \| (?:simulator|program)", PAGE.read_text("utf-8"), re.M))

    known = {
        kind
        for name, kind in vars(messages).items()
        if name.isupper() and isinstance(kind, bytes) and len(kind) == 1
    }
    assert kinds == {kind.decode() for kind in known}


def test_every_letter_of_an_error_is_on_the_page() -> None:
    letters = re.findall(r"^\| `(\w)` \| (\w+ \w+)", PAGE.read_text("utf-8"), re.M)

    named = {letter.encode(): words.replace(" ", "_") for letter, words in letters}
    assert named == {letter: str(verdict) for letter, verdict in messages.VERDICTS.items()}


def test_the_sizes_and_the_version_are_on_the_page() -> None:
    page = PAGE.read_text(encoding="utf-8")

    assert f"\nVersion {VERSION}." in page
    assert f"more\n  than {MAX_MESSAGE_BYTES} bytes" in page
    assert f"at most {messages.CHUNK_BYTES} bytes" in page


def test_the_example_of_the_page_is_what_the_code_packs() -> None:
    code = PAGE.read_text(encoding="utf-8").split("```")[1]
    octets = "".join(re.findall(r"^((?:[0-9a-f]{2} {1,2})+)", code, re.M))

    request = messages.message(messages.OBSERVE, 7, struct.pack("<4d", 0.25, 1.0, 2.0, 0.0))
    answer = messages.message(messages.COMMAND, 7, struct.pack("<4d", 0.5, 1.0, 0.0, 0.0))
    assert bytes.fromhex(octets) == request + answer


def test_the_header_has_the_fields_of_the_observation_in_their_order() -> None:
    text = HEADER.read_text(encoding="utf-8")
    struct_ = text[text.index("struct seamark_observation {") : text.index("} seamark_observation")]
    struct_ = struct_.replace("SEAMARK_MOST_JOINTS", str(MAX_JOINTS))
    fields = re.findall(r"^    (double|int) (\w+)(?:\[(\d+)\])?;", struct_, re.M)

    found = [(name, int(count or 0), kind == "int") for kind, name, count in fields]
    assert f"SEAMARK_MOST_JOINTS = {MAX_JOINTS} }}" in text
    assert [field for field in found if field[0] not in ADDED] == [
        (name, SIZES.get(count, count), name in observation.BOOLEANS)
        for name, count, _unit, _meaning in FIELDS
    ]


def test_every_vehicle_fits_the_array_of_the_header() -> None:
    too_many = {name for name in VEHICLES if len(load(name).thrusters) > MOST_THRUSTERS}

    assert too_many == set(), "raise the size in seamark.h, runner.c and embedded_coder.py"


def test_the_runner_knows_every_field_of_the_observation() -> None:
    text = RUNNER.read_text("utf-8").replace("SEAMARK_MOST_JOINTS", str(MAX_JOINTS))
    known = re.findall(r'\{"(\w+)", AT\((\w+)\), (\d+), (\d)\}', text)

    assert [(name, at, int(count), int(boolean)) for name, at, count, boolean in known] == [
        (name, name, SIZES.get(count, max(count, 1)), boolean)
        for name, count, _unit, _meaning in FIELDS
        for boolean in (int(name in observation.BOOLEANS),)
    ]


if __name__ == "__main__":
    text = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(TABLE.sub(lambda m: m[1] + table() + m[3], text), encoding="utf-8")

"""A vehicle's file: what is accepted, what each mistake is called, and hostile files."""

import hashlib
import json
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from seamark import sim
from seamark.sim.registry import VEHICLES
from seamark.sim.vehicles import Vehicle, load
from seamark.sim.vehicles.fields import QUANTITY_KEYS, unit_of
from seamark.sim.vehicles.reading import (
    BODY_KEYS,
    HULL_MAX,
    THRUST_KEYS,
    THRUSTERS_MAX,
    TOP_KEYS,
    VehicleInvalid,
    read_vehicle,
)
from seamark.sim.vehicles.toml_reading import BYTES_MAX
from tests.sim.vehicles.hostile_files import HOSTILE

PLAIN = VEHICLES["bluerov2-heavy"].read_text("utf-8")
EXTENDING = 'format = 1\nname = "mine"\ntitle = "Mine"\nsummary = "Mine."\nextends = "girona500"\n'
QUICK_S = 5.0  # of CPU; the slowest takes a tenth

# Of every number, name and text of a vehicle that released benchmarks use: it never changes.
RELEASED = {
    "girona500": "34bf907b0c33c165826b6132ebd5f68e8e00027440630e1afef21940c383b3ee",
    "girona500-uwsim": "e1d1e710ddb3ad9ad9b93ed37b9f3abb686e9b62d769d67e7bbec19d7055327d",
    "bluerov2-heavy": "210e395e4f1fc93e1b6d74030a48ba5ae5b8571ae9eb68a1e9373a5e632470b8",
}


def read(text: str | bytes) -> Vehicle:
    return read_vehicle(text.encode() if isinstance(text, str) else text, base=load)


def refused(text: str | bytes) -> str:
    """Return what is said about a file that is refused, in bounded time."""
    start = time.process_time()
    with pytest.raises(VehicleInvalid) as found:
        read(text)
    assert time.process_time() - start < QUICK_S
    assert all(len(sentence) < 1000 for sentence in found.value.errors)
    assert len(found.value.errors) <= 21
    return str(found.value)


def changed(before: str, after: str) -> str:
    assert before in PLAIN
    return PLAIN.replace(before, after, 1)


def content_of(value: Any) -> Any:
    """Return a vehicle as JSON, without what the newest fields say: its first form."""
    match value:
        case dict():
            old = value.keys() - {"spread", "mounts", "lettered", "text"}
            return {key: content_of(one) for key, one in value.items() if key in old}
        case list() | tuple():
            return [content_of(one) for one in value]
    return value


@pytest.mark.parametrize("name", RELEASED)
def test_a_vehicle_of_released_benchmarks_never_changes(name: str) -> None:
    content = content_of(asdict(load(name)))

    text = json.dumps(content, sort_keys=True, ensure_ascii=False, indent=1)

    assert hashlib.sha256(text.encode()).hexdigest() == RELEASED[name]


def test_a_file_that_extends_a_vehicle_has_what_it_does_not_replace() -> None:
    mine, base = read(f"{EXTENDING}[drawing]\nnozzle_radius_m = 0.2\n"), load("girona500")

    assert mine.name == "mine"
    assert mine.nozzle_radius_m == 0.2
    assert list(mine.quantities()) == list(base.quantities())
    assert mine.solids == base.solids


def test_a_single_quantity_of_an_extended_vehicle_can_be_replaced() -> None:
    mass = '[body]\nmass = { value = 150, unit = "kg", tag = "E", reason = "with a lamp" }\n'

    mine, base = read(EXTENDING + mass), load("girona500")

    assert (mine.mass.scalar, mine.mass.source) == (150.0, "with a lamp")
    assert mine.inertia == base.inertia
    assert mine.curve == base.curve


def test_a_spread_is_read_for_each_number() -> None:
    wide = changed(
        'value = [141.0, 217.0, 190.0], unit = "N s²/m²"',
        'value = [141.0, 217.0, 190.0], spread = [[18.0, 21.0, 36.0], [142.0, 218.0, 244.0]], '
        'unit = "N s²/m²"',
    )  # fmt: skip

    spread = read(wide).drag_quadratic[0].spread

    assert spread == ((18.0, 21.0, 36.0), (142.0, 218.0, 244.0))


def test_a_file_says_where_an_arm_is_put() -> None:
    mount = """[mounts.my-arm]
place = { value = [0.3, 0, 0.1], unit = "m", tag = "E", reason = "a ruler" }
"""

    mine, base = read(EXTENDING + mount), read(EXTENDING)

    assert mine.mounts["my-arm"].point.value == (0.3, 0.0, 0.1)
    assert mine.mounts["my-arm"].turn.value == (0.0, 0.0, 0.0)
    assert ("mount my-arm", mine.mounts["my-arm"].point) in list(mine.quantities())
    assert base.mounts == load("girona500").mounts


MISPLACED = {
    "no place": ("[mounts.hook]\n", "mounts.hook.place is missing"),
    "no table": ("mounts = { hook = 3 }\n", "mounts.hook is no table"),
    "a key": ("[mounts.hook]\nplce = 1\n", "did you mean place?"),
    "a name": (
        '[mounts."My arm"]\n',
        "mounts: the name of an arm must be at most 40 small letters",
    ),
    "a long name": (f"[mounts.{1500 * 'a'}]\n", "mounts: the name of an arm must be at most 40"),
    "many": ("".join(f"[mounts.a{i}]\n" for i in range(17)), "mounts: there are 17; at most 16"),
}


@pytest.mark.parametrize(("text", "sentence"), MISPLACED.values(), ids=MISPLACED)
def test_a_mistake_in_the_place_of_an_arm_is_a_sentence(text: str, sentence: str) -> None:
    assert sentence in refused(EXTENDING + text)


@pytest.mark.parametrize("written", ["kg m²", "kg m^2", "kg*m^2", "kg·m²", " kg  m**2 "])
def test_units_may_be_written_with_a_keyboard(written: str) -> None:
    assert unit_of(written) == "kg m²"


MISTAKES = {
    "unit": ('13.5, unit = "kg"', '13.5, unit = "g"', 'body.mass.unit must be "kg", not \'g\''),
    "no unit": ('13.5, unit = "kg",', "13.5,", 'body.mass: unit is missing; write unit = "kg"'),
    "tag": ('"kg", tag = "S"', '"kg", tag = "X"', "body.mass.tag says where the number is from"),
    "tag of a list": ('"kg", tag = "S"', '"kg", tag = ["S"]', "body.mass.tag"),
    "source": ('"kg", tag = "S", source = "tank"', '"kg", tag = "S", source = "lake"',
               "body.mass.source: 'lake' is not in [sources]"),
    "no source": ('"kg", tag = "S", source = "tank"', '"kg", tag = "S"',
                  "body.mass: source is missing; tag S needs one"),
    "no reason": ('"kg", tag = "S", source = "tank"', '"kg", tag = "E"',
                  "body.mass: write a source from [sources], or a reason"),
    "sign": ("mass = { value = 13.5", "mass = { value = -13.5", "must be above 0, not -13.5"),
    "text": ("mass = { value = 13.5", 'mass = { value = "13.5"', "must be a number, not '13.5'"),
    "boolean": ("mass = { value = 13.5", "mass = { value = true", "must be a number, not True"),
    "infinite": ("mass = { value = 13.5", "mass = { value = inf", "must be a finite number"),
    "not a number": ("mass = { value = 13.5", "mass = { value = nan", "must be a finite number"),
    "huge": ("mass = { value = 13.5", f"mass = {{ value = {'9' * 1500}", "must be a finite"),
    "missing": ("mass = { value", "masss = { value", "did you mean mass?"),
    "count": ("[0.26, 0.23, 0.37]", "[0.26, 0.23]", "body.inertia.value must be a list of 3"),
    "axes": ('axes = ["x", "y", "z"], value = [13.7, 0.0, 33.0]',
             'axes = ["x", "z"], value = [13.7, 33.0]', "each once and in this order, not x, z"),
    "mixed axes": ('axes = ["x", "y", "z"], value = [13.7', 'axes = ["x", "yaw"], value = [13.7',
                   "axes must be a list of x, y, z, or of roll, pitch, yaw"),
    "lag": ("lag = { value = 0.1", "lag = { value = 0.0", "thrust.lag.value must be above 0"),
    "kind": ('kind = "quadratic"', 'kind = "cubic"', "one of quadratic, polynomial, not 'cubic'"),
    "direction": ("direction = [0.0, 0.0, 1.0]", "direction = [0, 3, 4]", "[0.0, 0.6, 0.8]"),
    "no direction": ("direction = [0.0, 0.0, 1.0]", "direction = [0, 0, 0]", "must not be zero"),
    "name": ('name = "bluerov2-heavy"', 'name = "../etc/passwd"', "small letters, digits and"),
    "twice": ('name = "front port"', 'name = "front starboard"', "'front starboard' is taken"),
    "letters": (
        'colour = "#20262b"',
        'colour = "#20262b", lettered = 1',
        "drawing.solids 5.lettered must be true or false",
    ),
    "colour": ('"#20262b"', '"red;}"', "drawing.solids 5.colour must be # and six digits"),
    "shape": ('"sphere"', '"torus"', "one of box, cylinder, capsule, sphere, not 'torus'"),
    "default": ("tilt_hold = true", "tilt_hold = [1]", "defaults.tilt_hold must be a number"),
    "default's name": ("tilt_hold = true", '"__class__" = true', "is not the name of a setting"),
    "format": ("format = 1", "format = 2", "format must be 1"),
    "control characters": ('title = "BlueROV2 Heavy"', 'title = "a\\u001b[2J"', "printable"),
    "spread": ("mass = { value = 13.5", "mass = { spread = [14, 15], value = 13.5",
               "body.mass.spread must enclose the value"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_a_sentence_with_its_key(mistake: str) -> None:
    before, after, said = MISTAKES[mistake]

    assert said in refused(changed(before, after))


def test_all_mistakes_are_told_at_once() -> None:
    text = changed('13.5, unit = "kg"', '13.5, unit = "g"').replace('"box"', '"cube"')

    assert refused(text).count("must be") > 5


@pytest.mark.parametrize("name", ["nothing", "../girona500", "/etc/passwd", "girona500.toml", "."])
def test_a_file_extends_nothing_but_our_vehicles(name: str) -> None:
    said = refused(EXTENDING.replace("girona500", name))

    assert f"there is no vehicle called {name!r}" in said


def test_vehicles_that_extend_each_other_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, base in (("one", "other"), ("other", "one")):
        text = EXTENDING.replace("mine", name).replace("girona500", base)
        tmp_path.joinpath(f"{name}.toml").write_text(text, encoding="utf-8")
        monkeypatch.setitem(VEHICLES, name, tmp_path / f"{name}.toml")

    with pytest.raises(VehicleInvalid, match="extends itself"):
        load("one")


@pytest.mark.parametrize("attack", HOSTILE)
def test_a_hostile_file_is_refused_in_bounded_time(attack: str) -> None:
    assert refused(HOSTILE[attack]())


def test_a_bracket_in_a_text_or_comment_is_no_nesting() -> None:
    title = 'title = "BlueROV2 Heavy"'

    read(changed(title, f'{title[:-1]} {"[" * 50}" # {"[" * 50} "'))


@pytest.mark.parametrize("name", VEHICLES)
def test_a_file_is_called_as_its_vehicle(name: str) -> None:
    assert VEHICLES[name].stem == load(name).name


def test_the_documentation_has_every_key_and_a_file_that_can_be_read() -> None:
    page = Path(sim.__file__).resolve().parents[1].joinpath("docs/vehicles.md").read_text("utf-8")
    example = page.split("```toml\n")[1].split("```")[0]
    keys = {*TOP_KEYS, *BODY_KEYS, *THRUST_KEYS, *QUANTITY_KEYS, "position", "direction", "solids"}

    assert read(example).mass.tag == "M"
    assert {key for key in keys if f"`{key}`" not in page and f"[{key}]" not in page} == set()
    assert f"{BYTES_MAX // 1024} KiB" in page
    assert f"1 to {THRUSTERS_MAX}" in page
    assert f"1 to {HULL_MAX} boxes" in page

"""Files of arms and things: ours are sound, and each mistake of a stranger's is a sentence."""

import time
from dataclasses import fields

import numpy as np
import pytest

from seamark.sim.registry import ARMS, THINGS
from seamark.sim.vehicles import TAGS, cylinder
from seamark.sim.vehicles.linkage import Body, Linkage
from seamark.sim.vehicles.linkage_reading import (
    LINKS_MAX,
    LinkageInvalid,
    load_linkage,
    read_linkage,
)

QUICK_S = 5.0  # of CPU
HOOK = ARMS["hook"].read_text("utf-8")
UPPER_ARM_MASS = 'mass = { value = 1.0, unit = "kg"'


def refused(text: str | bytes) -> str:
    """Return what is said about a file that is refused, in bounded time."""
    start = time.process_time()
    with pytest.raises(LinkageInvalid) as found:
        read_linkage(text.encode() if isinstance(text, str) else text)
    assert time.process_time() - start < QUICK_S
    assert len(found.value.errors) <= 21
    assert all(len(sentence) < 1000 for sentence in found.value.errors)
    return str(found.value)


def changed(before: str, after: str) -> str:
    assert before in HOOK
    return HOOK.replace(before, after, 1)


def number(value: str, unit: str) -> str:
    return f'{{ value = {value}, unit = "{unit}", tag = "E", reason = "a test" }}'


def body(linkage: Linkage, name: str) -> Body:
    found = linkage.link(name).body
    assert found is not None
    return found


@pytest.mark.parametrize("name", ARMS | THINGS)
def test_every_number_of_ours_says_where_it_is_from(name: str) -> None:
    linkage = load_linkage(name)

    assert linkage.name == name
    for what, quantity in linkage.quantities():
        assert quantity.source, what
        assert quantity.tag in TAGS, what
        assert np.isfinite(quantity.value).all(), what


@pytest.mark.parametrize("name", ARMS)
def test_every_joint_of_our_arms_has_a_range_and_friction_or_follows_another(name: str) -> None:
    moving = [link.joint for link in load_linkage(name).links if link.joint.kind != "fixed"]

    assert moving
    assert all(joint.range for joint in moving)
    assert all(joint.follows or (joint.effort and joint.friction) for joint in moving)


@pytest.mark.parametrize("name", ARMS)
def test_our_arms_have_a_camera_a_force_sensor_and_looks(name: str) -> None:
    arm = load_linkage(name)

    assert arm.camera
    assert arm.force_sensor
    assert any(link.solids for link in arm.links)
    assert arm.outer


def test_the_larger_arm_weighs_what_the_review_says() -> None:
    arm = load_linkage("arm-5e-like")
    volume = sum(link.body.volume.scalar for link in arm.links if link.body)

    assert arm.mass() == pytest.approx(27.0)
    assert arm.mass() - 1000.0 * volume == pytest.approx(18.5)


def test_what_is_derived_from_a_cylinder_is_an_estimate() -> None:
    found = body(load_linkage("hook"), "upper arm")
    derived = [each.name for each in fields(Body) if each.name not in ("mass", "centre")]

    assert {getattr(found, name).tag for name in derived} == {"E"}
    assert found.volume.scalar == pytest.approx(np.pi * 0.025**2 * 0.3)
    assert found.inertia.value[:3] == pytest.approx([3.125e-4, 7.65625e-3, 7.65625e-3])


def test_numbers_that_are_given_win_over_those_of_the_cylinder() -> None:
    text = changed(UPPER_ARM_MASS, f"added_mass = {number('[1, 2, 3]', 'kg')}\n{UPPER_ARM_MASS}")

    assert body(read_linkage(text.encode()), "upper arm").added_mass.value == (1.0, 2.0, 3.0)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_cylinder_is_slender_along_its_axis(axis: int) -> None:
    inertia = cylinder.inertia_of(1.0, 0.5, 0.01, axis).value
    added = cylinder.added_mass_of(0.5, 0.01, axis).value

    assert int(np.argmin(inertia)) == axis
    assert int(np.argmin(added)) == axis


def test_links_may_be_listed_before_their_parents() -> None:
    top, upper, *rest = HOOK.split("\n[[links]]\n")
    last, tail = rest[-1].split("\n[camera]")
    text = "\n[[links]]\n".join([top, last, *rest[:-1], upper]) + f"\n[camera]{tail}"

    assert [link.name for link in read_linkage(text.encode()).links] == [
        *("upper arm", "forearm", "hook")
    ]


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("format = 1", "format = 2", "format must be 1"),
        ("format = 1", "format = true", "format must be 1"),
        ('kind = "arm"', 'kind = "leg"', "kind must be one of arm, thing"),
        ('title = "Hook', 'titel = "Hook', "did you mean title?"),
        ('parent = "upper arm"', 'parent = "forearm"', "forearm hangs on itself"),
        ('parent = "upper arm"', 'parent = "tail"', "hangs on 'tail', which is no link"),
        ('name = "upper arm"', 'name = "upper arm"\nparent = "hook"', "go round in a circle"),
        ('name = "forearm"', 'name = "hook"', "'hook' is taken"),
        (UPPER_ARM_MASS, 'mass = { value = 0.0, unit = "kg"', "mass.value must be above 0, not 0"),
        (UPPER_ARM_MASS, 'mass = { value = -1, unit = "kg"', "mass.value must be above 0, not -1"),
        (UPPER_ARM_MASS, 'mass = { value = nan, unit = "kg"', "must be a finite number"),
        (UPPER_ARM_MASS, 'mass = { value = true, unit = "kg"', "must be a number"),
        (UPPER_ARM_MASS, 'mass = { value = 1.0, unit = "lb"', 'unit must be "kg"'),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "must not be zero"),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 1.0]", "a list of three numbers"),
        ('kind = "revolute"', 'kind = "free"', "those of an arm are not free"),
        ('kind = "revolute"', 'kind = "ball"', "kind must be one of fixed, free"),
        ('kind = "capsule"', 'kind = "mesh"', "kind must be one of capsule, box"),
        ('name = "hook tip"', 'name = "hull: tip"', "is no name for a link or a shape"),
        ('name = "upper arm"', 'name = "vehicle"', "'vehicle' is no name for a link"),
        ('name = "hook tip"', 'name = "hook back"', "two shapes have the same name"),
        ('hull = ["forearm"]', f"hull = {['forearm'] * 13}", "at most 12 names of shapes"),
        ('hull = ["forearm"]', 'hull = ["tail"]', "there is no shape 'tail'"),
        ('hull = ["forearm"]', 'touches = [["forearm"]]', "must be two names of shapes"),
        ('hull = ["forearm"]', 'touches = [["hook back", "hook tip"]]', "both are of one link"),
        ('link = "upper arm"', 'link = "tail"', "camera.link: there is no link 'tail'"),
        ('axis = "x"', 'axis = "w"', "axis must be one of x, y, z"),
    ],
)
def test_each_mistake_is_named(before: str, after: str, said: str) -> None:
    assert said in refused(changed(before, after))


@pytest.mark.parametrize(
    ("inertia", "said"),
    [
        ("[1, 1, 0]", "positive definite"),
        ("[1, 1, -1]", "positive definite"),
        ("[1, 1, 1, 2, 0, 0]", "positive definite"),
        ("[1, 1, 2.1]", "more than the sum of the other two, 2 kg m²"),
        ("[1, 1, 1, 0.9, 0, 0]", "that of no body"),
        ("[1, 1, 1, 0]", "must be xx, yy, zz, or these and xy, xz, yz"),
    ],
)
def test_an_inertia_that_no_body_has_is_refused(inertia: str, said: str) -> None:
    text = changed(UPPER_ARM_MASS, f"inertia = {number(inertia, 'kg m²')}\n{UPPER_ARM_MASS}")

    assert said in refused(text)


def test_a_flat_plate_has_an_inertia_that_is_accepted() -> None:
    text = changed(UPPER_ARM_MASS, f"inertia = {number('[1, 1, 2]', 'kg m²')}\n{UPPER_ARM_MASS}")

    assert body(read_linkage(text.encode()), "upper arm").inertia.value[2] == 2.0


@pytest.mark.parametrize(
    ("line", "said"),
    [
        (f"range = {number('[1, -1]', 'rad')}", "its lower end, then its upper one"),
        (f"range = {number('[-100, 100]', 'rad')}", "its lower end, then its upper one"),
        (f"friction = {number('[1, 2]', 'N m')}", "that to break away, then that in motion"),
        (f"effort = {number('3', 'N m')}", "both effort and speed"),
        (f"effort = {number('3', 'N')}", 'unit must be "N m"'),
        ('follows = { link = "upper arm", ratio = 1 }', "follow another link"),
        ('follows = { link = "hook", ratio = 1 }', "follow another link"),
        ('follows = { link = "forearm", ratio = 0 }', "from 0.001 to 1000"),
        ('follows = { link = "forearm" }', "ratio must be a number"),
    ],
)
def test_a_joint_that_cannot_be_is_refused(line: str, said: str) -> None:
    joint = f'[links.joint]\nkind = "revolute"\naxis = [0, 1, 0]\n{line}\n[links.body]'
    start = HOOK.index("[links.joint]")
    text = HOOK[:start] + joint + HOOK[HOOK.index("[links.body]") + len("[links.body]") :]

    assert said in refused(text)


def test_a_link_that_moves_needs_a_mass() -> None:
    start, end = HOOK.index("[links.body]"), HOOK.index("[[links.shapes]]")

    assert "body is missing" in refused(HOOK[:start] + HOOK[end:])


def test_all_mistakes_are_told_at_once() -> None:
    without_unit = UPPER_ARM_MASS.removesuffix(', unit = "kg"')
    said = refused(changed('kind = "arm"', 'kind = "leg"').replace(UPPER_ARM_MASS, without_unit))

    assert "kind must be one of" in said
    assert "unit is missing" in said


@pytest.mark.parametrize("count", [LINKS_MAX + 1, 2000])
def test_too_many_links_are_refused(count: int) -> None:
    top = HOOK.partition("[[links]]")[0]
    link = '[[links]]\nname = "l{}"\n[links.joint]\nkind = "fixed"\n'

    text = top + "".join(link.format(i) for i in range(count))

    assert f"there must be 1 to {LINKS_MAX}, not {count}" in refused(text)


def test_the_longest_chain_of_links_is_read() -> None:
    top = 'format = 1\nkind = "thing"\nname = "chain"\ntitle = "t"\nsummary = "s"\n'
    link = '[[links]]\nname = "l{}"\n{}[links.joint]\nkind = "fixed"\n'
    parents = ["", *(f'parent = "l{i}"\n' for i in range(LINKS_MAX - 1))]

    text = top + "".join(link.format(i, parent) for i, parent in enumerate(parents))

    assert len(read_linkage(text.encode()).links) == LINKS_MAX


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe",
        b"x" * 300_000,
        b"links = " + b"[" * 100_000,
        b"a." * 100_000 + b"b = 1",
        b"format = 1\nkind = 1\nname = 2\nlinks = 3\ncamera = 4\ntouches = 5\nsources = 6\n",
        b'format = 1\nkind = "arm"\nlinks = [1, "a", []]\n',
        b"format = " + b"9" * 5000,
        b"format = 1\n" + b"".join(b"k%d = 1\n" % i for i in range(20_000)),
        b"format = 1\nouter = [[]]\nhull = [{}]\ntouches = [[[], {}], [1, 2]]\n",
    ],
)
def test_hostile_files_are_refused_with_words(content: bytes) -> None:
    assert refused(content)


@pytest.mark.parametrize("name", ["nothing", "../hook", "bluerov2-heavy"])
def test_unknown_linkages_are_not_found(name: str) -> None:
    with pytest.raises(LookupError, match="no arm and no thing called"):
        load_linkage(name)

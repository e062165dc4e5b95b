"""Fields from a schema: what is shown is read back as the same values."""

from hypothesis import given
from hypothesis import strategies as st

from seamark.programs.setting_values import is_applicable, text_of
from seamark.server.pages.benchmark import form_fields
from seamark.sim import registry
from seamark.sim.trackers import option_names

SCHEMA = registry.benchmark("currents-v1").schema()
finite = st.floats(allow_nan=False, allow_infinity=False, width=64)


def _number_schema(kind: str) -> dict[str, object]:
    return {"properties": {"x": {"type": kind, "default": 0}}}


@given(value=finite)
def test_a_number_shown_in_a_field_is_read_back_unchanged(value: float) -> None:
    shown = text_of(value)

    assert form_fields.read(_number_schema("number"), {"x": shown}) == {"x": value}


@given(values=st.lists(finite, min_size=1, max_size=12))
def test_a_list_shown_in_a_field_is_read_back_unchanged(values: list[float]) -> None:
    shown = text_of(values)

    assert form_fields.read(_number_schema("array"), {"x": shown}) == {"x": values}


@given(text=st.text())
def test_any_text_can_be_read_from_a_form(text: str) -> None:
    form = dict.fromkeys(SCHEMA["properties"], text)

    values = form_fields.read(SCHEMA, form)

    assert set(values) == set(SCHEMA["properties"])


def test_an_unchanged_form_gives_the_defaults_of_each_vehicle() -> None:
    benchmark = registry.benchmark("currents-v1")

    for vehicle in registry.VEHICLES:
        shown = form_fields.groups(SCHEMA, {"vehicle": vehicle}, {})
        entries = [entry for group in shown for entry in (*group.basic, *group.advanced)]
        texts = {entry.name: entry.value for entry in entries}
        posted = {name: text for name, text in texts.items() if text != "false"}
        form = posted | {f"{name}.there": "1" for name in texts}
        read = benchmark.read(form_fields.read(SCHEMA, form))
        assert read == benchmark.read({"vehicle": vehicle})


def test_an_unticked_checkbox_is_false_only_if_the_form_had_it() -> None:
    schema = {"properties": {"x": {"type": "boolean", "default": True}}}

    assert form_fields.read(schema, {}) == {}
    assert form_fields.read(schema, {"x.there": "1"}) == {"x": False}
    assert form_fields.read(schema, {"x.there": "1", "x": "on"}) == {"x": True}


def test_groups_follow_the_order_given() -> None:
    order = ("Tracker", "Current")

    titles = [group.title for group in form_fields.groups(SCHEMA, {}, {}, order=order)]

    assert tuple(titles[:2]) == order


def test_a_setting_applies_only_with_the_choices_that_use_it() -> None:
    entry = {"x-applies": {"tracker": ["esm", "visp"], "warp": ["homography"]}}

    assert is_applicable(entry, {"tracker": "visp", "warp": "homography"})
    assert not is_applicable(entry, {"tracker": "klt", "warp": "homography"})
    assert not is_applicable(entry, {"tracker": "esm", "warp": "srt"})
    assert is_applicable({}, {})


def test_every_option_of_a_tracker_says_with_which_trackers_it_applies() -> None:
    for name in registry.TRACKERS:
        for option in option_names(name):
            assert name in SCHEMA["properties"][option]["x-applies"]["tracker"]


def test_a_setting_of_a_position_controller_is_shown_with_the_controllers_that_use_it() -> None:
    schema = registry.benchmark("currents-v1").schema()
    fields = {
        field.name: field
        for group in form_fields.groups(schema, {}, {})
        for field in (*group.basic, *group.advanced)
    }

    assert fields["pid_kd"].condition == "Solution pid"
    assert fields["kp"].condition == "Solution p or pi or upload"
    assert is_applicable(schema["properties"]["pid_kd"], {"controller": "pid"})
    assert not is_applicable(schema["properties"]["pid_kd"], {"controller": "pi"})

"""Parameters that programs declare, read without running them."""

import io
import json
import re
import zipfile
from pathlib import Path

import pytest

from seamark.programs.parameters import Parameter
from seamark.programs.preparation import PreparedProgram, prepare
from seamark.sandbox.languages import fmu as fmu_language

_CLASS = """
class Controller:
    def __init__(self, config): ...
    def step(self, observation): ...
"""
_DESCRIPTION = Path(fmu_language.__file__).parent / "starter/modelDescription.xml"


def _python(declaration: str) -> PreparedProgram:
    return prepare((declaration + _CLASS).encode(), "mine.py")


def _fmu(**files: str) -> PreparedProgram:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as members:
        for name, text in files.items():
            members.writestr(name.replace("__", "/").replace("_xml", ".xml"), text)
    return prepare(archive.getvalue(), "model.fmu")


def test_a_python_program_declares_its_parameters_in_a_literal() -> None:
    found = _python(
        'PARAMETERS = {"gain": {"default": 0.5, "range": [0, 2], "unit": "1/s",\n'
        '    "description": "Proportional gain"}, "order": 3, "use_current": True}\n'
    )

    gain = Parameter(
        name="gain", default=0.5, low=0, high=2, unit="1/s", description="Proportional gain"
    )
    order, switch = Parameter(name="order", default=3), Parameter(name="use_current", default=True)
    assert found.diagnostics == ()
    assert found.parameters == (gain, order, switch)
    assert [one.type for one in found.parameters] == ["number", "integer", "boolean"]


@pytest.mark.parametrize(
    ("declaration", "part"),
    [
        ("PARAMETERS = load()\n", "must be a literal"),
        ('PARAMETERS = {"gain": 2 * scale}\n', "must be a literal"),
        ('PARAMETERS = {"gain": {"range": [0, 1]}}\n', "needs a default"),
        ('PARAMETERS = {"gain": {"default": 0.5, "minimum": 0}}\n', "has no minimum"),
        ('PARAMETERS = {"gain": {"default": 3.0, "range": [0, 2]}}\n', "from 0 to 2, not 3.0"),
        ('PARAMETERS = {"gain": {"default": 1.0, "range": [2, 0]}}\n', "[lowest, highest]"),
        ('PARAMETERS = {"gain": {"default": 1.0, "range": "wide"}}\n', "[lowest, highest]"),
        ('PARAMETERS = {"a b": 1.0}\n', "cannot be the name"),
        ('PARAMETERS = {"gain": "high"}\n', "must be a number, not 'high'"),
        ('PARAMETERS = {"gain": 1e999}\n', "must be a number"),
        ("PARAMETERS = {" + "".join(f'"p{i}": 1.0, ' for i in range(70)) + "}\n", "64 parameters"),
    ],
)
def test_a_wrong_declaration_in_python_is_named_with_its_line(declaration: str, part: str) -> None:
    first = _python(declaration).diagnostics[0]

    assert part in first.sentence
    assert (first.file, first.line) == ("mine.py", 1)


def test_a_program_that_mentions_parameters_elsewhere_declares_none() -> None:
    found = _python("def f():\n    PARAMETERS = 3\n")

    assert (found.parameters, found.diagnostics) == ((), ())


@pytest.mark.parametrize("name", ["mine.c", "mine.cpp", "mine.m"])
def test_a_text_in_another_language_declares_them_in_comments(name: str) -> None:
    mark = "%" if name.endswith(".m") else "//"
    source = (
        f"{mark} @parameter gain 0.5 [0, 2] (1/s) Proportional gain\n"
        f"{mark} @parameter order 3\n"
        f"  {mark} @parameter use_current true whether it is estimated\n"
        f"{mark} @parameter floor -1e-3 [, 0]\n"
    )

    found = prepare(source.encode(), name)

    assert found.diagnostics == ()
    assert found.parameters == (
        Parameter(
            name="gain", default=0.5, low=0, high=2, unit="1/s", description="Proportional gain"
        ),
        Parameter(name="order", default=3),
        Parameter(name="use_current", default=True, description="whether it is estimated"),
        Parameter(name="floor", default=-0.001, high=0),
    )


@pytest.mark.parametrize(
    "line", ["// @parameter gain", "// @parameter gain 0.5 [0 2]", "/* @parameter gain high */"]
)
def test_a_wrong_comment_is_named_with_its_line(line: str) -> None:
    first = prepare(f"int x;\n{line}\n".encode(), "mine.c").diagnostics[0]

    assert "@parameter name default" in first.sentence
    assert (first.file, first.line) == ("mine.c", 2)


def test_a_comment_on_several_lines_and_a_string_are_told_apart() -> None:
    source = b'/*\n * @parameter gain 0.5\n */\nconst char *s = "@parameter no 1";\n'

    assert [one.name for one in prepare(source, "mine.c").parameters] == ["gain"]


def test_an_fmu_declares_those_of_its_model_description() -> None:
    text = _DESCRIPTION.read_text().replace(
        '<Real start="0.5"/>', '<Real start="0.5" min="0" max="2" unit="1/s"/>'
    )

    found = _fmu(modelDescription_xml=text)

    assert [one.name for one in found.parameters] == [
        *("kp", "ki", "reference_limit_m_s", "control_heave")
    ]
    assert found.parameters[0] == Parameter(name="kp", default=0.5, low=0, high=2, unit="1/s")
    assert found.parameters[3].default is False


def test_parameters_that_the_mapping_of_an_fmu_connects_are_not_declared() -> None:
    mapping = json.dumps({"parameters": {"ki": "kp"}})

    found = _fmu(modelDescription_xml=_DESCRIPTION.read_text(), **{"extra__seamark.json": mapping})

    assert "ki" not in [one.name for one in found.parameters]


def test_an_unreadable_model_description_is_left_to_the_box() -> None:
    found = _fmu(modelDescription_xml="<not")

    assert (found.parameters, found.diagnostics) == ((), ())


def test_the_samples_of_the_documentation_declare_what_it_says() -> None:
    text = (Path(__file__).parents[3] / "docs/languages.md").read_text()
    section = text[text.index("## Parameters") : text.index("### Sweeps")]
    python, c = re.findall(r"```(?:python|c)\n(.*?)```", section, re.DOTALL)

    found = [prepare(python.encode(), "mine.py"), prepare(c.encode(), "mine.c")]

    assert [one.diagnostics for one in found] == [(), ()]
    assert found[0].parameters == found[1].parameters
    assert [one.name for one in found[0].parameters] == ["gain", "use_heave"]

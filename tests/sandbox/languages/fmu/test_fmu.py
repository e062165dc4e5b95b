"""What is reported when an FMU does not fit: the names on both sides, before it is loaded."""

import io
import json
import zipfile

import pytest
from hypothesis import given
from hypothesis import strategies as st

from seamark.sandbox.languages.fmu.inside.build import BUILD, Build, build_of
from seamark.sandbox.languages.fmu.inside.description import Unusable, read
from seamark.sandbox.languages.fmu.inside.wiring import Wiring, wired
from seamark.sandbox.languages.inside.port_names import command_spans, observation_spans
from seamark.sandbox.languages.inside.wire import COMMAND

LAYOUT = {"observation": [["t", 0], ["error", 3], ["attitude", 3], ["thrust", 2]]}
MODEL = '<CoSimulation modelIdentifier="m"/>'


def scalar(name: str, causality: str, number: int = 0, kind: str = "Real") -> str:
    return (
        f'<ScalarVariable name="{name}" valueReference="{number}" causality="{causality}">'
        f"<{kind}/></ScalarVariable>"
    )


def vector(name: str, causality: str, size: str) -> str:
    return (
        f'<Float64 name="{name}" valueReference="1" causality="{causality}">'
        f"<Dimension {size}/></Float64>"
    )


ENOUGH = scalar("surge", "output", 1) + scalar("sway", "output", 2)


def fmu(
    variables: str = "", *, version: str = "2.0", model: str = MODEL, mapping: object = None
) -> bytes:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        text = (
            f'<fmiModelDescription fmiVersion="{version}" guid="1">{model}'
            f"<ModelVariables>{variables}</ModelVariables></fmiModelDescription>"
        )
        archive.writestr("modelDescription.xml", text)
        archive.writestr("binaries/win64/m.dll", b"")
        if mapping is not None:
            archive.writestr("extra/seamark.json", json.dumps(mapping))
    return whole.getvalue()


def wiring(data: bytes, config: dict[str, object] | None = None) -> Wiring:
    return wired(read(data), LAYOUT, config or {})


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"text", "zip archive"),
        (b"PK\x03\x04" + bytes(100), "zip archive"),
        (fmu(version="1.0"), "FMI 1.0; FMI 2.0 and 3.0"),
        (fmu(model='<ModelExchange modelIdentifier="m"/>'), "co-simulation"),
        (fmu(ENOUGH.replace('"1"', '"x"')), "surge has no integer valueReference"),
        (fmu(scalar("surge", "output")), "no output sway. Its outputs are: surge; wanted"),
        (fmu(), "no output surge and sway. Its outputs are: none"),
        (
            fmu(ENOUGH + scalar("errorx", "input")),
            "no observation has: errorx. .* error_x, error_y",
        ),
        (fmu(ENOUGH + scalar("t", "input", kind="String")), "t is not of a numeric type"),
        (fmu(ENOUGH, mapping=[1]), "extra/seamark.json must be an object"),
        (fmu(ENOUGH, mapping={"input": {}}), "objects inputs, outputs, parameters"),
        (fmu(ENOUGH, mapping={"inputs": {"e": "t"}}), "has e, which is no input .* are: none"),
        (fmu(ENOUGH, mapping={"outputs": {"heave": "h"}}), "h, to which heave is mapped. Its out"),
        (fmu(ENOUGH, mapping={"outputs": {"pitch": "surge"}}), "there are surge, sway, heave"),
        (
            fmu(ENOUGH + scalar("g", "parameter"), mapping={"parameters": {"g": "kp"}}),
            "g is mapped to kp, which is not a number",
        ),
        (
            fmu(ENOUGH + scalar("error", "input")),
            "error has 1 numbers, not 3",
        ),
        (
            fmu(vector("command", "output", 'valueReference="9"'), version="3.0"),
            "command has 0 numbers, not 4",
        ),
    ],
)
def test_what_does_not_fit_is_named(data, says) -> None:
    with pytest.raises(Unusable, match=says):
        wiring(data)


def test_an_archive_without_a_description_is_refused() -> None:
    whole = io.BytesIO()
    with zipfile.ZipFile(whole, "w") as archive:
        archive.writestr("folder/modelDescription.xml", b"")

    with pytest.raises(Unusable, match=r"no modelDescription\.xml in its topmost folder"):
        read(whole.getvalue())


def test_a_mapping_connects_other_names_and_numbers() -> None:
    variables = (
        scalar("In1", "input", 1)
        + scalar("In2", "input", 2)
        + scalar("gain", "parameter", 3)
        + scalar("Out1", "output", 4)
    )
    mapping = {
        "inputs": {"In1": "error_x", "In2": 2.5},
        "parameters": {"gain": "kp"},
        "outputs": {"surge": "Out1", "sway": 0.25},
    }

    found = wiring(fmu(variables, mapping=mapping), {"kp": 0.5})

    assert [(end.variable.name, end.span.offset) for end in found.inputs] == [("In1", 1)]
    assert [(end.variable.name, end.value) for end in found.constants] == [
        ("In2", 2.5),
        ("gain", 0.5),
    ]
    assert [(end.variable.name, end.span.offset) for end in found.outputs] == [("Out1", 0)]
    assert found.fixed == {1: 0.25}


def test_an_element_of_a_vector_has_three_names() -> None:
    spans = observation_spans(LAYOUT)

    assert spans["error[2]"] == spans["error_2"] == spans["error_y"]
    assert spans["yaw"] == spans["attitude[3]"]
    assert spans["thrust[2]"].offset == 8
    assert command_spans(COMMAND)["yaw_rate"] == command_spans(COMMAND)["command[4]"]


BUILT = """
<BuildConfiguration modelIdentifier="other" platform="x86_64-linux"/>
<BuildConfiguration modelIdentifier="m" platform="x86_64-windows"/>
<BuildConfiguration modelIdentifier="m">
  <SourceFileSet language="C99">{files}</SourceFileSet>{more}
</BuildConfiguration>"""


def build(text: str) -> Build:
    whole = io.BytesIO(fmu(version="3.0"))
    with zipfile.ZipFile(whole, "a") as archive:
        archive.writestr("sources/a.c", b"")
        archive.writestr("sources/more/b.c", b"")
        archive.writestr("sources/unused.c", b"")
        archive.writestr(BUILD, f"<fmiBuildDescription>{text}</fmiBuildDescription>")
    return build_of(read(whole.getvalue()))


def test_sources_of_fmi_3_are_compiled_as_their_build_description_says() -> None:
    files = (
        '<SourceFile name="more/b.c"/><SourceFile name="a.c"/>'
        '<PreprocessorDefinition name="SIZE" value="3"/><IncludeDirectory name="more"/>'
    )

    found = build(BUILT.format(files=files, more=""))

    assert found.sources == ["sources/more/b.c", "sources/a.c"]
    assert found.options == ["-DSIZE=3", "-Isources/more"]


@pytest.mark.parametrize(
    ("files", "more", "says"),
    [
        ("", '<Library name="lapack"/>', "libraries lapack"),
        ('<SourceFile name="c.c"/>', "", "sources/c.c, which is not in the FMU"),
        ('<SourceFile name="../a.c"/>', "", "outside"),
        ('<SourceFile name="/etc/passwd"/>', "", "outside"),
        ('<IncludeDirectory name="../../x"/>', "", "outside"),
        ('<PreprocessorDefinition name="A -fplugin=x"/>', "", "not a valid name"),
        ("", '<SourceFileSet language="C++11"/>', r"C\+\+11 sources"),
        ("", '<SourceFileSet compilerOptions="-ffast-math"/>', "C -ffast-math"),
    ],
)
def test_unsupported_parts_of_a_build_description_are_refused_by_name(files, more, says) -> None:
    with pytest.raises(Unusable, match=says):
        build(BUILT.format(files=files, more=more))


def test_a_build_for_another_machine_is_refused() -> None:
    with pytest.raises(Unusable, match="no BuildConfiguration for m on x86_64-linux"):
        build('<BuildConfiguration modelIdentifier="m" platform="aarch64-linux"/>')


@given(st.binary(max_size=400))
def test_arbitrary_bytes_read_as_an_fmu_raise_nothing_else(data) -> None:
    with pytest.raises(Unusable):
        read(data)

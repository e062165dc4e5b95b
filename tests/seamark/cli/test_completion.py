"""Shell completion, in a real bash."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner

from seamark.cli.main import COMMANDS, cli

ASK = """
compopt() {{ :; }}  # bash has it only while a key is pressed
eval "$({command} completion bash)"
COMP_WORDS=({words})
COMP_CWORD=$(( ${{#COMP_WORDS[@]}} - 1 ))
_seamark_completion {command}
printf '%s\\n' "${{COMPREPLY[@]}}"
"""


def complete(folder: Path, words: str) -> list[str]:
    """Return what bash offers after these words."""
    command = folder / "seamark"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m seamark.cli.main "$@"\n')
    command.chmod(0o755)
    done = subprocess.run(
        ["bash", "--norc", "-c", ASK.format(command="seamark", words=words)],
        cwd=folder,
        env=os.environ | {"PATH": f"{folder}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stderr == ""
    return done.stdout.split()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "offered"),
    [
        ("seamark com", ["compare", "competition", "completion"]),
        ("seamark run currents-v", ["currents-v3", "currents-v2", "currents-v1"]),
        ("seamark tune currents-v1 --controller p", ["p", "pi", "pi-ff", "pid"]),
        ("seamark tune currents-v1 --controller pi-", ["pi-ff"]),
        ("seamark plot --on", ["--only"]),
    ],
)
def test_bash_completes_commands_benchmarks_solutions_and_options(
    words: str, offered: list[str], tmp_path: Path
) -> None:
    assert complete(tmp_path, words) == offered


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_has_a_script_that_asks_this_command(shell: str) -> None:
    answer = CliRunner().invoke(cli, ["completion", shell])

    assert answer.exit_code == 0
    assert f"_SEAMARK_COMPLETE={shell}_complete" in answer.output


def test_completing_a_command_imports_no_command() -> None:
    code = (
        "import sys, os; os.environ.update(_SEAMARK_COMPLETE='bash_complete',"
        "COMP_WORDS='seamark t', COMP_CWORD='1')\n"
        "from seamark.cli.main import cli\n"
        "try: cli.main([], prog_name='seamark')\n"
        "except SystemExit: pass\n"
        "assert not [one for one in sys.modules if one.startswith('seamark.cli.commands.')]"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)

    assert done.returncode == 0, done.stderr
    assert [line.split(",")[1] for line in done.stdout.splitlines()] == [
        name for name in COMMANDS if name.startswith("t")
    ]

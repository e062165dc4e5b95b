"""`seamark submit` with a file."""

from pathlib import Path

from click.testing import CliRunner

from seamark.cli.main import cli

STILL = """class Controller:
    def __init__(self, config):
        pass

    def reset(self, level):
        pass

    def step(self, observation):
        return 0.0, 0.0, 0.0, 0.0
"""


def test_a_file_is_submitted_as_a_program_of_ones_own(
    address: str, token: str, tmp_path: Path
) -> None:
    program = tmp_path / "still.py"
    program.write_text(STILL)
    options = ["--controller", str(program), "--server", address, "--token", token]

    answer = CliRunner().invoke(cli, ["submit", "currents-v1", *options])

    assert answer.exit_code == 0, answer.output
    assert f"{address}/runs/1" in answer.output

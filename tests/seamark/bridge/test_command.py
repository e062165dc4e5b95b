"""What `seamark bridge` refuses before it listens."""

import pytest
from click.testing import CliRunner

from seamark.cli.main import cli


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("rosbridge", "visibility-v1"), "visibility-v1 evaluates a tracker"),
        (("rosbridge", "currents-v1", "--host", "192.0.2.1"), "192.0.2.1:9090 cannot be used"),
        (("ardusub", "currents-v1", "--host", "192.0.2.1"), "192.0.2.1:9002 cannot be used"),
        (("ardusub", "currents-v1", "--set", "vehicle=girona500"), "not girona500"),
        (("ardusub", "currents-v1", "--set", "speed=1"), "speed"),
    ],
)
def test_a_bridge_that_cannot_work_says_why(arguments: tuple[str, ...], reason: str) -> None:
    answer = CliRunner().invoke(cli, ["bridge", *arguments])

    assert answer.exit_code == 2
    assert reason in answer.output

"""`./run` beside something else that uses the package manager of the machine."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
TOOLS = ("dirname", "sh", "sed", "seq", "tr", "cat", "grep")
# Its lists are locked at the first two attempts; then it knows the package.
APT_GET = """\
#!/bin/sh
echo "$*" >> "$CALLS"
case "$*" in
    update*)
        if [ "$(grep -c '^update' "$CALLS")" -le 2 ]; then
            echo "E: Could not get lock /var/lib/apt/lists/lock. It is held by process 1" >&2
            exit 100
        fi
        ;;
esac
"""


def _program(folder: Path, name: str, text: str) -> None:
    (folder / name).write_text(text)
    (folder / name).chmod(0o755)


@pytest.mark.slow
def test_an_installation_waits_for_another_process_that_has_the_lists_locked(
    tmp_path: Path,
) -> None:
    programs, calls = tmp_path / "bin", tmp_path / "calls"
    programs.mkdir()
    for tool in TOOLS:
        (programs / tool).symlink_to(shutil.which(tool) or "")
    _program(programs, "apt-get", APT_GET)
    _program(programs, "id", "#!/bin/sh\necho 0\n")
    _program(programs, "sleep", "#!/bin/sh\n")

    ended = subprocess.run(
        [str(ROOT / "run"), "languages"],
        env={"PATH": str(programs), "CALLS": str(calls)} | {"HOME": os.environ["HOME"]},
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )

    done = calls.read_text().splitlines()
    assert [call for call in done if call.startswith("update")] == ["update -qq"] * 3
    assert any("install -y" in call and "bubblewrap" in call for call in done)
    assert ended.stderr.count("waiting for it") == 1


@pytest.mark.slow
def test_the_quick_tests_are_those_without_browser_boxes_and_postgresql() -> None:
    """Collect some files that have tests of both kinds."""
    quick = re.search(r'-m "(.+)" "\$@"', (ROOT / "run").read_text("utf-8"))
    assert quick is not None
    files = (
        "journey/test_event_loops.py",
        "server/database/test_advisory_locks.py",
        "server/runs/queue/test_order.py",
    )

    collected = subprocess.run(
        [sys.executable, "-m", "pytest", "--collect-only", "-q", "-m", quick[1], *files],
        cwd=ROOT / "tests",
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )

    names = [line.partition("::")[2] for line in collected.stdout.splitlines()]
    assert [name for name in names if name] == [
        "test_another_test_of_the_process_can_run_an_event_loop",
        "test_no_two_critical_sections_share_a_lock",
        "test_the_key_orders_runs_as_claims_one_after_the_other",
        "test_the_shares_are_counted_as_they_are_mixed",
        "test_the_position_of_a_run_is_the_one_at_which_it_starts[sqlite]",
    ]

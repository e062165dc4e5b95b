"""Programs that are installed while the service runs are noticed once the installation is over."""

import os
from pathlib import Path

from seamark.embedded.installed_tools import InstalledTools


def _install(status: Path, at_ns: int) -> None:
    status.write_text("octave\n")
    os.utime(status, ns=(at_ns, at_ns))


def test_an_installation_counts_when_nothing_follows_it(tmp_path: Path) -> None:
    status = tmp_path / "status"
    tools = InstalledTools((status, tmp_path / "missing"), every_s=0.0)
    seen = [tools.changed()]

    for at_ns in (1_000, 2_000):
        _install(status, at_ns)
        seen.append(tools.changed())
    seen += [tools.changed(), tools.changed()]

    assert seen == [False, False, False, True, True]


def test_an_accepted_installation_does_not_count_again(tmp_path: Path) -> None:
    status = tmp_path / "status"
    tools = InstalledTools((status,), every_s=0.0)
    _install(status, 1_000)
    seen = [tools.changed(), tools.changed()]

    tools.accept()
    seen += [tools.changed(), tools.changed()]

    assert seen == [False, True, False, False]

"""`seamark init`: a controller to start from, in any of the languages."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.failures import UsageRefused
from seamark.options import say

LANGUAGES = ("python", "c", "c++", "matlab", "fmu")  # as in templates_for_programs.KINDS


@click.command()
@click.option("--language", type=click.Choice(LANGUAGES), default="python", show_default=True)
@click.argument("folder", type=click.Path(path_type=Path), metavar="[DIR]", default=".")
def init(*, language: str, folder: Path) -> None:
    """Write a controller that runs as it is into DIR, to start from.

    For C and C++ the header seamark.h comes along, for your editor: the sandbox has its own. For
    an FMU there are its sources too: it is a zip archive of them.

    \b
    Examples:
      seamark init
      seamark init --language c++ my_controller
    """
    from server.pages import templates_for_programs

    files = templates_for_programs.start(language)
    taken = [name for name in files if (folder / name).exists()]
    if taken:
        raise UsageRefused(f"{folder / taken[0]} is there already; nothing was written.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in files.items():
            (folder / name).parent.mkdir(exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError as error:
        raise UsageRefused(f"{folder} cannot be written: {error.strerror}.") from None
    main = folder / next(iter(files))
    say(f"Wrote {', '.join(str(folder / name) for name in files)}. Try it:")
    say(f"  seamark run currents-v1 --controller {main} --set levels=0,0.2")

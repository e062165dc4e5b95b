"""`seamark init`: a controller to start from, in any of the languages."""

from __future__ import annotations

from pathlib import Path

import click

from seamark.failures import UsageRefused
from seamark.options import say

LANGUAGES = ("python", "c", "c++", "matlab")


@click.command()
@click.option("--language", type=click.Choice(LANGUAGES), default="python", show_default=True)
@click.argument("folder", type=click.Path(path_type=Path), metavar="[DIR]", default=".")
def init(*, language: str, folder: Path) -> None:
    """Write a controller that runs as it is into DIR, to start from.

    For C and C++ the header seamark.h comes along, for your editor: the sandbox has its own.

    \b
    Examples:
      seamark init
      seamark init --language c++ my_controller
    """
    from server.pages import templates_for_programs

    files = {templates_for_programs.FILES[language]: templates_for_programs.of(language)}
    if language in ("c", "c++"):
        files["seamark.h"] = templates_for_programs.header()
    taken = [name for name in files if (folder / name).exists()]
    if taken:
        raise UsageRefused(f"{folder / taken[0]} is there already; nothing was written.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in files.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise UsageRefused(f"{folder} cannot be written: {error.strerror}.") from None
    main = folder / next(iter(files))
    say(f"Wrote {', '.join(str(folder / name) for name in files)}. Try it:")
    say(f"  seamark run currents-v1 --controller {main} --set levels=0,0.2")

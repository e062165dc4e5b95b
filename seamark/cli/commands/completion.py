"""`seamark completion`: the script with which a shell completes commands, options and names."""

from __future__ import annotations

import click

from seamark.cli.console import print_json
from seamark.cli.options import json_option


@click.command()
@click.argument("shell", type=click.Choice(("bash", "zsh", "fish")))
@json_option
def completion(shell: str, *, as_json: bool) -> None:
    """Print the completion script of a shell: bash 4.4 or later, zsh or fish.

    \b
    Examples:
      echo 'eval "$(seamark completion bash)"' >> ~/.bashrc
      echo 'eval "$(seamark completion zsh)"' >> ~/.zshrc
      seamark completion fish > ~/.config/fish/completions/seamark.fish
    """
    from click.shell_completion import get_completion_class

    from seamark.cli.main import cli

    script_class = get_completion_class(shell)
    if script_class is None:
        raise click.UsageError(f"click does not support {shell}.")
    script = script_class(cli, {}, "seamark", "_SEAMARK_COMPLETE")
    # Not `source()`, which starts bash to look at its version.
    text = script.source_template % script.source_vars()
    if as_json:
        print_json({"shell": shell, "script": text})
    else:
        click.echo(text)

"""The command line, without carrying anything out."""

import click


def parse(command: click.Command, words: list[str]) -> None:
    """Parse a command line as the program does; nothing is run."""
    context = click.Context(command)
    if isinstance(command, click.Group):
        below = command.get_command(context, words[0])
        assert below is not None, words
        parse(below, words[1:])
    else:
        command.parse_args(context, list(words))

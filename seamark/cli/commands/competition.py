"""`seamark competition`: organise competitions, take part in them, and check them."""

from __future__ import annotations

import click

from seamark.cli.commands import competition_audit, competition_draft, competition_team


@click.group()
def competition() -> None:
    """Organise a competition, take part in one or check it; see docs/competitions.md."""


for _command in (
    *(competition_draft.init, competition_draft.check, competition_draft.create),
    *(competition_draft.open_up, competition_draft.move),
    *(competition_team.show, competition_team.join, competition_audit.audit),
):
    competition.add_command(_command)

"""`seamark competition audit`: compute a competition anew from its audit file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from seamark.cli import competition_text
from seamark.cli.console import exit_with, print_json
from seamark.cli.extras import need_simulator
from seamark.cli.options import json_option
from seamark.failures import UsageRefused

if TYPE_CHECKING:
    from seamark.competitions.findings import Finding


@click.command()
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "--recompute",
    is_flag=True,
    help="Also compute the runs of built-in solutions again: minutes for each.",
)
@json_option
def audit(*, file: Path, recompute: bool, as_json: bool) -> None:
    """Compute anew what follows from the audit FILE of a competition, and say what is wrong.

    That is the SHA-256 of its frozen document, whether rounds and rules are those in it, the
    commitments of the revealed keys, the seed of each run, the means of all scores, and the
    standings of the final. Compare the commitments that it prints with those that were published
    before the rounds. Exit code 1: something is wrong.

    \b
    Examples:
      seamark competition audit audit.json
      seamark competition audit audit.json --recompute
    """
    need_simulator("seamark competition audit")
    from seamark.competitions.findings import Level

    document = _read(file)
    findings = _checked(file, document)
    if recompute:
        from seamark.cli.competition_runs import recomputed
        from seamark.competitions.audit_document import read

        findings += recomputed(read(document), quiet=as_json)
    problems = sum(finding.level == Level.PROBLEM for finding in findings)
    if as_json:
        told = [{"level": each.level, "sentence": each.sentence} for each in findings]
        print_json({"sound": problems == 0, "findings": told})
    else:
        _show(findings, problems)
    exit_with(1 if problems else 0)


def _read(file: Path) -> dict[str, Any]:
    from seamark.competitions.audit_document import BYTES_MAX, AuditInvalid, load

    with file.open("rb") as stream:
        content = stream.read(BYTES_MAX + 1)
    try:
        return load(content)
    except AuditInvalid as reason:
        raise UsageRefused(f"{file.name} is no audit file: {reason}.") from None


def _checked(file: Path, document: dict[str, Any]) -> list[Finding]:
    from seamark.competitions.audit import verify
    from seamark.competitions.audit_document import AuditInvalid

    try:
        return verify(document)
    except AuditInvalid as reason:
        raise UsageRefused(f"{file.name} cannot be checked: {reason}.") from None


def _show(findings: list[Finding], problems: int) -> None:
    for finding in findings:
        click.echo(competition_text.finding_line(finding.level, finding.sentence))
    click.echo("")
    if problems:
        click.echo(f"{problems} of {len(findings)} checks found something wrong; see above.")
    else:
        click.echo("Nothing is wrong with what can be checked.")

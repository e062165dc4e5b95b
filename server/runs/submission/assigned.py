"""Runs for an assignment: what the assignment fixes, and what the student may choose."""

from dataclasses import replace

from sqlalchemy.orm import Session

from seamark.server.classes import assignments
from seamark.server.classes.refusals import ClassRefused
from seamark.server.programs import vehicles
from seamark.server.runs.record.states import RunKind
from seamark.server.runs.submission.fixed_settings import with_fixed
from seamark.server.runs.submission.validation import Submission, SubmissionRejected
from seamark.sim import registry


def for_assignment(session: Session, assignment_id: int, sent: Submission) -> Submission:
    """Return a submission with the kind, the settings, the seed and the trials of an assignment.

    The student chooses the program and the settings of a built-in solution.

    Raises
    ------
    SubmissionRejected
        The sender may not submit for it now, or sent something else than it asks for.
    ConfigurationInvalid
        A setting of the scenario has an invalid value.
    """
    if sent.vehicle is not None:
        raise SubmissionRejected(
            "An assignment fixes the vehicle. Leave yours out.", field=vehicles.FIELD
        )
    try:
        assignment = assignments.open_for(session, assignment_id, sent.viewer.user_id)
    except ClassRefused as refusal:
        raise SubmissionRejected(str(refusal), field=refusal.field) from None
    if sent.benchmark != assignment.benchmark:
        raise SubmissionRejected(
            f"This assignment asks for runs of {assignment.benchmark}, not of {sent.benchmark}.",
            field="benchmark",
        )
    if assignment.is_ranked:
        return replace(sent, assignment=assignment.id, kind=RunKind.RANKED, seed=None, trials=None)
    if assignment.seed is not None and sent.seed not in (None, assignment.seed):
        raise SubmissionRejected(
            f"This assignment fixes the seed to {assignment.seed}. Leave the seed out.",
            field="seed",
        )
    return replace(
        sent,
        assignment=assignment.id,
        kind=RunKind.PRACTICE,
        seed=sent.seed if assignment.seed is None else assignment.seed,
        trials=assignment.trials,
        config=assignment.config
        | with_fixed(
            registry.benchmark(assignment.benchmark),
            assignment.fixed(),
            sent.config,
            by="assignment",
        ),
    )

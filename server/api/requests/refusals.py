"""Maps refusals (of a submission, upload, quota, check, class or competition) to a problem."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from seamark.competitions.document import DocumentInvalid
from seamark.programs.preparation import UploadRejected, UploadTooLarge
from seamark.server.classes.refusals import ClassRefused
from seamark.server.competitions.refusals import CompetitionRefused
from seamark.server.programs import vehicles
from seamark.server.programs.check_queue import CheckRefused
from seamark.server.programs.vehicles import VehicleRejected, VehicleTooLarge
from seamark.server.runs.submission.quota import QuotaExceeded
from seamark.server.runs.submission.validation import (
    AccountNeeded,
    SignInNeeded,
    SubmissionRejected,
)
from seamark.server.web.problems import Problem
from seamark.sim.settings.refusal import ConfigurationInvalid


@contextmanager
def as_problems() -> Iterator[None]:
    """Raise a refusal that occurs in this block as a problem."""
    try:
        yield
    except (ConfigurationInvalid, DocumentInvalid) as refusal:
        configures = isinstance(refusal, ConfigurationInvalid)
        slug = "invalid-configuration" if configures else "invalid-request"
        raise Problem(slug, str(refusal), errors=refusal.errors) from None
    except CompetitionRefused as refusal:
        raise _of_competition(refusal) from None
    except ClassRefused as refusal:
        raise _of_field("invalid-request", refusal) from None
    except SubmissionRejected as refusal:
        raise _of_submission(refusal) from None
    except (UploadRejected, VehicleRejected) as refusal:
        large = isinstance(refusal, UploadTooLarge | VehicleTooLarge)
        field = vehicles.FIELD if isinstance(refusal, VehicleRejected) else refusal.field
        slug = "payload-too-large" if large else "upload-rejected"
        raise Problem(slug, str(refusal), errors={field: str(refusal)}) from None
    except QuotaExceeded as refusal:
        raise _to_retry("quota-exceeded", refusal) from None
    except CheckRefused as refusal:
        raise _to_retry("rate-limited", refusal) from None


def _of_competition(refusal: CompetitionRefused) -> Problem:
    """Blame a field of the request, or else the state of the competition."""
    return _of_field("invalid-request" if refusal.field else "conflict", refusal)


def _of_submission(refusal: SubmissionRejected) -> Problem:
    if isinstance(refusal, SignInNeeded):
        return Problem("unauthenticated")
    slug = "account-needed" if isinstance(refusal, AccountNeeded) else "invalid-request"
    return _of_field(slug, refusal)


def _of_field(
    slug: str, refusal: ClassRefused | CompetitionRefused | SubmissionRejected
) -> Problem:
    errors = {refusal.field: str(refusal)} if refusal.field else {}
    return Problem(slug, str(refusal), errors=errors)


def _to_retry(slug: str, refusal: QuotaExceeded | CheckRefused) -> Problem:
    return Problem(slug, str(refusal), headers={"Retry-After": str(refusal.retry_after_s)})

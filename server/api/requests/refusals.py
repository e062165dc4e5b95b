"""Maps refusals (of a submission, upload, quota, check or class) to a problem document."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from seamark.programs.preparation import UploadRejected, UploadTooLarge
from seamark.server.classes.refusals import ClassRefused
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
    except ConfigurationInvalid as refusal:
        raise Problem("invalid-configuration", str(refusal), errors=refusal.errors) from None
    except ClassRefused as refusal:
        errors = {refusal.field: str(refusal)} if refusal.field else {}
        raise Problem("invalid-request", str(refusal), errors=errors) from None
    except SubmissionRejected as refusal:
        raise _of_submission(refusal) from None
    except UploadRejected as refusal:
        slug = "payload-too-large" if isinstance(refusal, UploadTooLarge) else "upload-rejected"
        raise Problem(slug, str(refusal), errors={refusal.field: str(refusal)}) from None
    except VehicleRejected as refusal:
        slug = "payload-too-large" if isinstance(refusal, VehicleTooLarge) else "upload-rejected"
        raise Problem(slug, str(refusal), errors={vehicles.FIELD: str(refusal)}) from None
    except QuotaExceeded as refusal:
        raise _to_retry("quota-exceeded", refusal) from None
    except CheckRefused as refusal:
        raise _to_retry("rate-limited", refusal) from None


def _of_submission(refusal: SubmissionRejected) -> Problem:
    if isinstance(refusal, SignInNeeded):
        return Problem("unauthenticated")
    slug = "account-needed" if isinstance(refusal, AccountNeeded) else "invalid-request"
    errors = {refusal.field: str(refusal)} if refusal.field else {}
    return Problem(slug, str(refusal), errors=errors)


def _to_retry(slug: str, refusal: QuotaExceeded | CheckRefused) -> Problem:
    return Problem(slug, str(refusal), headers={"Retry-After": str(refusal.retry_after_s)})

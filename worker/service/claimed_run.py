"""The run of a claim, evaluated whatever happens: nobody keeps a lease on a run that broke."""

from contextlib import suppress

import structlog
from sqlalchemy.exc import SQLAlchemyError

from seamark.server.runs import queue
from seamark.server.runs.queue import Claim
from seamark.worker.service.run_driver import RunContext, blame, evaluate

_log = structlog.get_logger()


def evaluate_or_release(context: RunContext, claim: Claim) -> bool:
    """Evaluate a claimed run, and release it if that fails; False if the platform failed."""
    try:
        return evaluate(context, claim)
    except Exception as error:
        _log.exception("run_not_evaluated", run=claim.run_id, attempt=claim.attempt)
        end = blame(context.settings, error)
    with suppress(SQLAlchemyError), context.database.writing() as session:
        queue.release(session, claim, end, settings=context.settings)
    return False

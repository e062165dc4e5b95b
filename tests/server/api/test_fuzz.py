"""The interface keeps what its OpenAPI document promises, whatever is sent to it."""

from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from schemathesis.checks import CHECKS, not_a_server_error

from tests.server.api.conftest import Site

EXAMPLES = 6  # per operation
LEFT_OUT = "/events"  # a stream that never ends is no answer for a fuzzer
# These two judge how strict a parser is; a lenient one (trials = "3") is meant here.
LENIENT = {"negative_data_rejection", "positive_data_acceptance", "ignored_auth"}


@pytest.mark.slow
def test_every_response_matches_the_openapi_document(site: Site) -> None:
    site.publish(site.recorded())
    site.queue()
    schema = schemathesis.openapi.from_wsgi("/api/v1/openapi.json", site.app)
    checks: list[Any] = [check for check in CHECKS.get_all() if check.__name__ not in LENIENT]
    tried = 0

    for found in schema.exclude(path_regex=LEFT_OUT).get_all_operations():
        operation: Any = found.ok()  # type: ignore[union-attr]  # the document is valid

        @settings(
            max_examples=EXAMPLES,
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=list(HealthCheck),
        )
        @given(case=operation.as_strategy())
        def holds(case: schemathesis.Case[Any]) -> None:
            nonlocal tried
            tried += 1
            case.call_and_validate(headers=site.headers["owner"], checks=checks)

        holds()

    assert not_a_server_error in checks
    assert tried > 20

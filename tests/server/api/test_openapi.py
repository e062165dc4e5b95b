"""The OpenAPI document is fit for generating clients."""

import re
from typing import Any

import pytest

from seamark.server.api import RESOURCES, openapi

WITHOUT_BODY = frozenset(  # they change something, and their address says it all
    {
        *("actions_cancel", "actions_reveal", "actions_verify", "actions_withdraw"),
        *("runs_rerun", "sweeps_cancel"),
        *("competitions_open_competition", "teams_withdraw_entry", "teams_choose_entry"),
        *("classes_leave", "administration_revoke_access", "administration_make_reset_link"),
        *("administration_run_retention", "rejudgements_accept", "rejudgements_discard"),
    }
)


@pytest.fixture(scope="module")
def operations() -> dict[str, dict[str, Any]]:
    document = openapi.build(RESOURCES)
    listed = [each for methods in document["paths"].values() for each in methods.items()]
    found = {operation["operationId"]: operation | {"method": m} for m, operation in listed}
    assert len(found) == len(listed)  # no two have the same name
    return found


def test_the_name_of_an_operation_is_short(operations: dict[str, dict[str, Any]]) -> None:
    assert [name for name in operations if not re.fullmatch(r"[a-z]+(_[a-z0-9]+){1,3}", name)] == []
    assert {"runs_create", "runs_show", "actions_publish", "sweeps_create"} <= set(operations)


def test_every_change_describes_its_body(operations: dict[str, dict[str, Any]]) -> None:
    changes = {
        name for name, each in operations.items() if each["method"] in {"post", "put", "patch"}
    }

    assert {name for name in changes if "requestBody" not in operations[name]} == WITHOUT_BODY


@pytest.mark.parametrize("name", ["runs_create", "sweeps_create"])
def test_a_submission_is_json_or_a_form_with_a_program_and_may_have_a_key(
    operations: dict[str, dict[str, Any]], name: str
) -> None:
    content = operations[name]["requestBody"]["content"]
    headers = [each["name"] for each in operations[name]["parameters"] if each["in"] == "header"]

    assert set(content) == {"application/json", "multipart/form-data"}
    assert content["multipart/form-data"]["schema"]["properties"]["program"]["format"] == "binary"
    assert headers == ["Idempotency-Key"]


@pytest.mark.parametrize("name", ["files_camera", "files_telemetry_f64", "datasets_dataset"])
def test_a_file_is_described_as_bytes(operations: dict[str, dict[str, Any]], name: str) -> None:
    (content,) = operations[name]["responses"]["200"]["content"].values()

    assert content["schema"]["format"] == "binary"


def test_every_reference_leads_to_a_schema() -> None:
    document = openapi.build(RESOURCES)

    referred = set(re.findall(r"'#/components/schemas/(\w+)'", str(document)))

    assert referred <= set(document["components"]["schemas"])

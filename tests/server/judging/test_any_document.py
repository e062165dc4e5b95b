"""Whatever values a document has, it is read or refused with sentences."""

import copy
import json
from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from seamark.competitions.document import CompetitionDocument, DocumentInvalid
from seamark.server.judging import drafts
from tests.cast import Backend
from tests.server.judging.cup import values

SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20)
ANYTHING = st.recursive(
    SCALARS | st.sampled_from([2**70, -(2**70), 10**400, "9999-12-31T23:59:59-12:00"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=6,
)


def places(value: Any, *above: str | int) -> Iterator[tuple[str | int, ...]]:
    """Yield where something stands in a document."""
    inner = value.items() if isinstance(value, dict) else enumerate(value)
    for at, each in inner:
        yield (*above, at)
        if isinstance(each, dict | list):
            yield from places(each, *above, at)


def with_value(place: tuple[str | int, ...], value: Any) -> dict[str, Any]:
    document: Any = copy.deepcopy(FULL)
    part = document
    for at in place[:-1]:
        part = part[at]
    part[place[-1]] = value
    return dict(document)


FULL = values(programs="hidden", ties="earlier", team_size=5, methods=3)
PLACES = list(places(FULL))


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(place=st.sampled_from(PLACES), value=ANYTHING)
def test_any_value_at_any_place_is_read_or_refused_with_sentences(
    backend: Backend, place: tuple[str | int, ...], value: Any
) -> None:
    read, errors = None, dict[str, str]()
    try:
        read = drafts.read(with_value(place, value), backend.settings).document
    except DocumentInvalid as refusal:
        errors = refusal.errors

    assert (read is None) == bool(errors)
    assert all(errors.values())
    if read is not None:
        stored = json.loads(json.dumps(read.canonical(), allow_nan=False))
        assert CompetitionDocument.restore(stored) == read

"""Documents of competitions that nobody in good faith would send."""

import io
import json
from typing import Any

import pytest
from werkzeug.datastructures import FileStorage, MultiDict
from werkzeug.test import TestResponse, encode_multipart

from tests.cast import RECORD
from tests.server.api.conftest import Site
from tests.server.judging.cup import values

API = "/api/v1/competitions"
PNG = b"\x89PNG\r\n\x1a\n"


def wrong(place: str, value: Any) -> dict[str, Any]:
    """Return a document with a value at a place such as rounds.0.opens."""
    document = json.loads(json.dumps(values()))
    *path, last = [int(part) if part.isdigit() else part for part in place.split(".")]
    at: Any = document
    for part in path:
        at = at[part]
    at[last] = value
    return dict(document)


@pytest.mark.parametrize(
    ("place", "value"),
    [
        ("rounds.0.opens", 2**70),
        ("rounds.0.opens", -(2**70)),
        ("rounds.0.opens", float("nan")),
        ("rounds.0.opens", float("inf")),
        ("rounds.0.opens", "0001-01-01T00:00:00"),
        ("rounds.0.opens", "9999-12-31T23:59:59-12:00"),
        ("rounds.0.opens", "1" * 400),
        ("rounds.0.quota", 2**70),
        ("rounds.0.trials", 10**4000),
        ("rounds.1.kind", ["final"]),
        ("rounds", {"0": 1}),
        ("rounds", [[]] * 1000),
        ("settings.levels", [float("nan")]),
        ("settings.levels", [1e999]),
        ("settings.levels", [2**70]),
        ("settings.levels", "x" * 60_000),
        ("settings.vehicle", "../../etc/passwd"),
        ("settings.vehicle", "mine.toml"),
        ("settings.score", "score.__class__"),
        ("settings.score", "(" * 5000),
        ("settings.\x00\ud800", 1),
        ("settings", dict.fromkeys(map(str, range(5000)), 0)),
        ("name", "harbour-cup-v1\n"),
        ("name", "../harbour-cup-v1"),
        ("name", "h\u0430rbour-cup-v1"),
        ("title", "\ud800"),
        ("title", "\x00\x1b\u202e"),
        ("title", 5),
        ("rules", [["a"]]),
        ("rules", "x" * 8001),
        ("zone", "../../etc/passwd"),
        ("zone", "Europe/Madrid\x00"),
        ("benchmark", "\ud800"),
        ("benchmark", {}),
        ("team_size", 1e308),
    ],
)
def test_a_hostile_value_is_refused_and_named(hall: Site, place: str, value: Any) -> None:
    answer = hall.call("olga", "POST", API, json=wrong(place, value))

    assert answer.status_code == 422
    errors = answer.get_json()["errors"]
    assert errors[0]["field"].startswith(place.split(".", maxsplit=1)[0])
    assert len(errors) <= 20


def test_control_characters_do_not_reach_a_title(hall: Site) -> None:
    sent = values(title="Har\x1b[2Jbour\u202e\n Cup", rules="a\r\nb\x00", question="\x07Why?")
    document = hall.call("olga", "POST", API, json=sent).get_json()["document"]

    assert document["title"] == "Har[2Jbour Cup"
    assert document["rules"] == "a\nb"
    assert document["question"] == "Why?"


@pytest.mark.parametrize(
    ("body", "status"),
    [
        (b"[" * 100_000, 413),
        (b"[" * 60_000, 400),
        (b'{"settings": ' + b'{"a": ' * 5000 + b"1" + b"}" * 5001, 400),
        (b'{"settings": ' + b'{"a": ' * 400 + b"1" + b"}" * 401, 422),
        (b'{"\\ud800": 1}', 422),
        (b'{"name": ' + b"1" * 5000 + b"}", 400),
        (b"[]", 422),
        (b"", 400),
        (b"\xff\xfe", 400),
        (b"null", 422),
        (b"{}", 422),
    ],
)
def test_a_hostile_body_is_refused(hall: Site, body: bytes, status: int) -> None:
    answer = hall.call("olga", "POST", API, data=body, content_type="application/json")

    assert answer.status_code == status


@pytest.mark.parametrize(
    ("content", "status"),
    [
        (b"a = " + b"[" * 5000, 422),
        (b"x = 1\n" * 20_000, 413),
        (b"\xff", 422),
        (b"a.b.c.d.e.f = 1", 422),
        (b"[[rounds]]\nopens = 9999-12-31T23:59:59-12:00", 422),
        (b"name = nan", 422),
        (b"", 422),
    ],
)
def test_a_hostile_toml_file_is_refused(hall: Site, content: bytes, status: int) -> None:
    data = {"document": (io.BytesIO(content), "cup.toml")}

    assert hall.call("olga", "POST", API, data=data).status_code == status


def sent_with(hall: Site, **files: FileStorage) -> TestResponse:
    """Send a valid document with files that are not."""
    form = MultiDict[str, Any]({"document": json.dumps(values()), **files})
    boundary, body = encode_multipart(form)  # the client leaves the file of a large form open
    kind = f"multipart/form-data; boundary={boundary}"
    return hall.call("olga", "POST", API, data=body, content_type=kind)


@pytest.mark.parametrize(
    ("picture", "sentence"),
    [
        (b"GIF89a\x01\x00\x01\x00", "PNG or JPEG"),
        (b"<svg onload='alert(1)'/>", "PNG or JPEG"),
        (b"", "PNG or JPEG"),
        (b"<html>" + PNG, "PNG or JPEG"),
        (PNG + bytes(600 * 1024), "at most 512 KiB"),
    ],
)
def test_a_picture_that_is_none_is_refused(hall: Site, picture: bytes, sentence: str) -> None:
    answer = sent_with(hall, picture=FileStorage(io.BytesIO(picture), "cup.png"))

    assert answer.status_code == 422
    (error,) = answer.get_json()["errors"]
    assert error["field"] == "picture"
    assert sentence in error["detail"]


def test_a_vehicle_that_is_none_is_refused(hall: Site) -> None:
    data = {"document": json.dumps(values()), "vehicle": (io.BytesIO(PNG), "mine.toml")}
    answer = hall.call("olga", "POST", API, data=data)

    assert answer.status_code == 422
    assert answer.get_json()["errors"][0]["field"] == "vehicle"


@pytest.mark.parametrize(
    ("record", "sentence"),
    [
        (PNG, "text in UTF-8"),
        (RECORD.replace(",0.05,", ",nan,").encode(), "five numbers"),
        (RECORD.encode() + b"#" * 2_000_000, "at most"),
    ],
)
def test_a_record_that_is_none_is_refused(hall: Site, record: bytes, sentence: str) -> None:
    answer = sent_with(hall, current_record=FileStorage(io.BytesIO(record), "ria.csv"))

    assert answer.status_code == 422
    (error,) = answer.get_json()["errors"]
    assert error["field"] == "current_record"
    assert sentence in error["detail"]


@pytest.mark.parametrize(
    ("picture", "sentence"),
    [(PNG, "can be decoded"), (b"P5\n400 124\n255\n" + bytes(49_600), "no contrast")],
)
def test_a_picture_that_covers_no_target_is_refused(
    hall: Site, picture: bytes, sentence: str
) -> None:
    answer = sent_with(hall, target_texture=FileStorage(io.BytesIO(picture), "a.png"))

    assert answer.status_code == 422
    (error,) = answer.get_json()["errors"]
    assert error["field"] == "target_texture"
    assert sentence in error["detail"]


def test_a_form_without_a_document_or_of_another_kind_is_refused(hall: Site) -> None:
    form = hall.call("olga", "POST", API, data={"picture": (io.BytesIO(PNG), "a.png")})
    text = hall.call("olga", "POST", API, data=b"name = 1", content_type="application/toml")

    assert (form.status_code, text.status_code) == (422, 415)

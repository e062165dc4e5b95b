"""What a stranger sends costs the web process bounded time, memory and output: form by form."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from seamark.server.api.requests.schemas import CONFIG_MAX
from seamark.sim import registry
from tests.server.api.conftest import Site

CPU_S = 1.0
MEMORY_MIB = 64
ANSWER_MAX = 2**20  # [B]
RUNS, FORM = "/api/v1/runs", "/submit/currents-v1"
MIB = 2**20
URL_ENCODED, MULTIPART = "application/x-www-form-urlencoded", "multipart/form-data; boundary=b"
PART = b'--b\r\nContent-Disposition: form-data; name="%b"\r\n\r\n'
Request = tuple[str, dict[str, Any]]


def _json(value: object) -> Request:
    return RUNS, {"data": json.dumps(value), "content_type": "application/json"}


def _config(config: object) -> Request:
    return _json({"benchmark": "currents-v1", "controller": "pi", "config": config})


def _text(text: str) -> Request:
    return RUNS, {"data": text, "content_type": "application/json"}


def _raw(path: str, kind: str, body: bytes) -> Request:
    return path, {"data": body, "content_type": kind}


def _field(path: str, name: bytes, value: bytes) -> Request:
    return _raw(path, MULTIPART, PART % name + value + b"\r\n--b--\r\n")


def _program(run: str, name: str, content: bytes = b"x") -> Request:
    head = b'\r\n--b\r\nContent-Disposition: form-data; name="program"; filename="%b"\r\n\r\n'
    body = PART % b"run" + run.encode() + head % name.encode() + content + b"\r\n--b--\r\n"
    return _raw(RUNS, MULTIPART, body)


def _log(mapping: bytes) -> Request:
    log = b'--b\r\nContent-Disposition: form-data; name="log"; filename="a.csv"\r\n\r\nt\n0\r\n'
    body = log + PART % b"mapping" + mapping + b"\r\n--b--\r\n"
    return _raw("/api/v1/logs", MULTIPART, body)


ATTACKS: dict[str, Callable[[], Request]] = {
    "JSON: many unknown settings": lambda: _config({f"k{i}": 1 for i in range(20_000)}),
    "JSON: settings misspelled": lambda: _config({f"level_duration_{i}": 1 for i in range(9000)}),
    "JSON: a long setting": lambda: _config({"level_duration_s" * 15_000: 1}),
    "JSON: many unknown members": lambda: _json({f"k{i}": 1 for i in range(20_000)}),
    "JSON: deep": lambda: _text("[" * 250_000),
    "JSON: a long integer": lambda: _text('{"seed":' + "9" * 250_000 + "}"),
    "JSON: many levels": lambda: _config({"levels": [0.1] * 50_000}),
    "JSON: many levels as text": lambda: _config({"levels": "0," * 100_000}),
    "JSON: an expression of f-strings": lambda: _config({"score": "f'" + "{1}" * 60_000 + "'"}),
    "JSON: in a form": lambda: _program('{"config": {' + '"k": 1, ' * 500_000 + "}}", "a.py"),
    "form: many fields": lambda: _raw(FORM, URL_ENCODED, b"&a=" * (8 * MIB // 3)),
    "form: escapes": lambda: _raw(FORM, URL_ENCODED, b"a=" + b"%41" * (8 * MIB // 3)),
    "sign-in: many fields": lambda: _raw("/sign-in", URL_ENCODED, b"&a=" * (8 * MIB // 3)),
    "form: many parts": lambda: _raw(FORM, MULTIPART, (PART % b"a" + b"1\r\n") * 100_000),
    "form: many headers": lambda: _raw(FORM, MULTIPART, b"--b\r\n" + b"X-A: b\r\n" * MIB),
    "form: a long header": lambda: _raw(FORM, MULTIPART, b"--b\r\nX-A: " + b"b" * 4 * MIB),
    "form: many different names": lambda: _raw(
        FORM, URL_ENCODED, b"&".join(b"k%d=1" % number for number in range(1_000_000))
    ),
    "form: no delimiter": lambda: _raw(FORM, MULTIPART, b"\r\n--" * (2 * MIB)),
    "form: a list of levels": lambda: _field(FORM, b"levels", b"0," * (4 * MIB)),
    "form: a long number": lambda: _field(FORM, b"kp", b"9" * (8 * MIB)),
    "form: spaces before a number": lambda: _field(FORM, b"kp", b" " * (8 * MIB) + b"x"),
    "form: brackets in an expression": lambda: _field(FORM, b"score", b"(" * (8 * MIB)),
    "form: a long file name": lambda: _program('{"benchmark": "currents-v1"}', "a" * MIB + ".py"),
    "form: a long CSRF token": lambda: _field("/sign-in", b"csrf_token", b"b." * (4 * MIB)),
    "log: a mapping of quadratic cost": lambda: _log(b"a." * 8000 + b"a=1"),
    "form: a long password": lambda: _field("/sign-in", b"password", b"b" * (8 * MIB)),
}


def _memory_mib(name: str) -> float:
    """Return a figure of this process from /proc, such as VmRSS or its maximum VmHWM."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith(name))


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS)
def test_no_request_costs_much_time_memory_or_output(site: Site, attack: str) -> None:
    site.app.config["WTF_CSRF_METHODS"] = []  # whoever attacks has a valid token
    assert site.call("guest", "POST", RUNS, json={}).status_code == 422  # everything is loaded

    for role in ("guest", "owner"):
        _send(site, role, *ATTACKS[attack]())


def _send(site: Site, role: str, path: str, options: dict[str, Any]) -> None:
    """Send a request and check that it is refused at a small price."""
    Path("/proc/self/clear_refs").write_text("5")  # the maximum counts from here
    before, begin = _memory_mib("VmRSS"), time.process_time()

    answer = site.call(role, "POST", path, **options)

    assert 400 <= answer.status_code < 500
    assert time.process_time() - begin < CPU_S
    assert _memory_mib("VmHWM") - before < MEMORY_MIB
    assert len(answer.data) < ANSWER_MAX


@pytest.mark.parametrize("name", registry.BENCHMARKS)
def test_a_configuration_may_name_every_setting(name: str) -> None:
    assert len(registry.benchmark(name).schema()["properties"]) <= CONFIG_MAX


def test_a_guest_may_send_a_small_form_and_not_a_large_one(site: Site) -> None:
    _, small = _program('{"benchmark": "currents-v1"}', "a.py")
    _, large = _program('{"benchmark": "currents-v1"}', "a.py", b"#" * MIB)

    assert site.call("guest", "POST", RUNS, **small).get_json()["type"].endswith("needed")
    assert site.call("guest", "POST", RUNS, **large).status_code == 413


def test_a_problem_document_names_no_more_than_twenty_fields(site: Site) -> None:
    answer = site.call("owner", "POST", RUNS, json={f"k{i}": 1 for i in range(100)})

    assert len(answer.get_json()["errors"]) == 20


def test_a_problem_document_names_no_more_than_twenty_settings(site: Site) -> None:
    config = {f"no setting is like {i}": 1 for i in range(CONFIG_MAX)}
    document = {"benchmark": "currents-v1", "controller": "pi", "config": config}

    answer = site.call("owner", "POST", RUNS, json=document)

    assert answer.status_code == 422
    assert len(answer.get_json()["errors"]) == 20

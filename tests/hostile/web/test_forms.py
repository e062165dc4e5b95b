"""Forms whose fields hold what no browser sends: each is answered, none with a server error."""

import re

import pytest

from seamark.server.web import rate_limits
from seamark.sim import registry
from tests.server.pages.conftest import Site

FORMS = (
    *(f"/submit/{name}" for name in registry.BENCHMARKS),
    *("/sign-in", "/sign-up", "/tokens", "/password", "/invitations"),
)
WITH_PASSWORD = ("/sign-in", "/password")  # each costs a tenth of a second
VALUES = (
    *(
        "",
        " ",
        "x",
        "-",
        "+-5",
        "--1",
        "9" * 5000,
        "-" + "9" * 5000,
        "1e999",
        "nan",
        "-inf",
        "0x10",
    ),
    *("1_000", "\u0663", "\u00b2", "\u2212", "1,5", "1,,5", ",", "[", "()", "\u202e"),
    *("true", "null", "{}", "../x", "%s%n", "' OR 1=1 --", "a" * 16_000, "\r\n", "\x1b[2J"),
)


@pytest.mark.slow
@pytest.mark.parametrize("path", FORMS)
def test_no_text_in_a_form_is_a_server_error(
    site: Site, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rate_limits.limiter, "enabled", False)
    browser = site.browser("root")
    page = browser.get("/tokens" if path == "/password" else path).text
    names = set(re.findall(r'<(?:input|select|textarea)[^>]* name="([^"]+)"', page))
    fixed = names - {"csrf_token", "controller", "kind", "source"}
    assert fixed

    for value in VALUES[:: 4 if path in WITH_PASSWORD else 1]:
        for fields in (fixed, names - {"csrf_token"}):
            answer = browser.post(path, dict.fromkeys(fields, value))
            assert answer.status_code < 500, value[:20]


@pytest.mark.slow
@pytest.mark.parametrize("path", FORMS)
def test_no_text_in_the_address_of_a_form_is_a_server_error(site: Site, path: str) -> None:
    browser = site.browser("root")
    page = browser.get("/tokens" if path == "/password" else path).text
    names = set(re.findall(r' name="([^"]+)"', page)) | {"from", "next", "after", "of"}

    statuses = {
        browser.get(path, query_string=dict.fromkeys(names, value[:500])).status_code
        for value in VALUES
    }

    assert max(statuses) < 500

"""The service offers simulator and client of its own version and says how to install them."""

import re
from html import unescape

import pytest

from seamark.server.web.own_wheel import TAGS, OwnWheel
from tests.server.pages.conftest import Site

_TAG = re.compile(r"<[^<>]+>")


@pytest.mark.slow
@pytest.mark.parametrize("name", TAGS)
def test_the_service_sends_it_and_says_when_it_is_unchanged(site: Site, name: str) -> None:
    own, guest = OwnWheel(name).get("http://localhost"), site.browser()
    page = unescape(_TAG.sub("", guest.get("/docs/install").get_data(as_text=True)))

    sent = guest.get(f"/download/{own.name}")
    again = guest.get(f"/download/{own.name}", headers={"If-None-Match": sent.headers["ETag"]})

    assert f'pip install "{name} @ http://localhost/download/{own.name}"' in page
    assert (sent.status_code, sent.data) == (200, own.content)
    assert (again.status_code, again.data) == (304, b"")
    assert guest.get("/download/seamark-9.9.9-py3-none-any.whl").status_code == 404


def test_every_page_that_names_a_command_says_how_to_install_it(site: Site) -> None:
    guest = site.browser()

    for address in ("/docs/tracker", "/docs/controller", "/docs/guides/tutorial.md", "/api/docs"):
        assert 'href="/docs/install"' in guest.get(address).get_data(as_text=True)

"""Pages about what cannot be shown: what they advise, and where they lead."""

from urllib.parse import parse_qs, urlsplit

import pytest

from tests.server.pages.conftest import Site


@pytest.mark.slow
def test_who_is_signed_in_is_not_told_to_sign_in(site: Site) -> None:
    pages = {role: site.browser(role).get("/runs/999").text for role in ("stranger", "ann")}

    asked = {role: "sign in" in page.split("<main")[1] for role, page in pages.items()}
    assert asked == {"stranger": True, "ann": False}


def test_signing_in_leads_back_to_the_page_with_its_whole_query(site: Site) -> None:
    asked = "/tokens?of=all&state=failed"

    answer = site.browser().get(asked)

    assert answer.status_code == 302
    assert parse_qs(urlsplit(answer.location).query)["next"] == [asked]

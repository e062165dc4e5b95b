"""The steps of a sign-in by an identity provider."""

import httpx
from werkzeug.test import TestResponse

from seamark.client.sessions import NO_CERTIFICATES
from tests.server.pages.conftest import Browser, Site
from tests.services.oidc import path_of


def come_back(browser: Browser, following: str = "/runs/") -> str:
    """Go to the provider, which agrees, and return the address to which it sends the browser."""
    there = browser.get(f"/sign-in/provider?next={following}").headers["Location"]
    return path_of(httpx.get(there, verify=NO_CERTIFICATES).headers["Location"])


def sign_in(browser: Browser, following: str = "/runs/") -> TestResponse:
    return browser.get(come_back(browser, following))


def create(site: Site, name: str = "cleo") -> Browser:
    """Create an account by the identity of whoever is at the provider."""
    browser = site.browser()
    sign_in(browser)
    assert browser.post("/sign-up/provider", {"name": name}).status_code == 303
    return browser


def is_in(browser: Browser, name: str) -> bool:
    return f">{name}<" in browser.get("/").text

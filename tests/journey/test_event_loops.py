"""Tests with a browser leave the thread as they found it, in whatever order tests run."""

import asyncio

from playwright.sync_api import Browser


def test_a_browser_is_open(chromium: Browser) -> None:
    assert chromium.is_connected()


def test_another_test_of_the_process_can_run_an_event_loop() -> None:
    asyncio.run(asyncio.sleep(0))


def test_the_browser_of_later_tests_still_answers(chromium: Browser) -> None:
    context = chromium.new_context()
    assert context.new_page().evaluate("1 + 1") == 2
    context.close()

"""Chromium as it draws by itself where there is no graphics card."""

import io
import shutil
from collections.abc import Iterator
from contextlib import contextmanager

from PIL import Image
from playwright.sync_api import Browser, Locator, Page, sync_playwright

# WebGL by SwiftShader, the page by the processor. With `--use-angle=swiftshader` Chromium would
# compose the page by SwiftShader as well, which takes longer than the scene.
ARGUMENTS = ["--enable-unsafe-swiftshader", "--no-sandbox"]


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start the browser."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        try:
            yield browser
        finally:
            browser.close()


def picture(part: Page | Locator) -> Image.Image:
    """Return what a page or a part of it shows."""
    return Image.open(io.BytesIO(part.screenshot())).convert("RGB")

"""What axe finds wrong with a page that is open, in a theme or as it is."""

from collections.abc import Iterator
from typing import Any

from axe_playwright_python.base import AxeResults
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

# Of what passes a rule, nothing is reported: that takes longer than the rules.
_FOUND: dict[str, Any] = {"resultTypes": ["violations"]}
_UNFOLD = "for (const part of document.querySelectorAll('details')) part.open = true"
_THEME = "scheme => { document.documentElement.dataset.theme = scheme }"
_RUN = "async rules => ({violations: (await axe.run(rules)).violations})"
# One text of each look: its own style, and what its ancestors draw behind it. Texts of one look
# have one contrast.
_RUN_ON_LOOKS = """
async rules => {
  const looks = new Map(), backgrounds = new Map();
  const background = element => {
    if (element === null) return 0;
    if (!backgrounds.has(element)) {
      const { backgroundColor, backgroundImage, opacity, filter, position, zIndex } =
        getComputedStyle(element);
      const look = [background(element.parentElement), backgroundColor, backgroundImage, opacity,
        filter, position, zIndex].join();
      if (!looks.has(look)) looks.set(look, looks.size + 1);
      backgrounds.set(element, looks.get(look));
    }
    return backgrounds.get(element);
  };
  const texts = new Map();
  for (const element of document.body.querySelectorAll("*")) {
    const written = [...element.childNodes].map(({ nodeType, data }) =>
      nodeType === Node.TEXT_NODE ? data.trim() : "").join("");
    if (!written && !element.matches("input, select, textarea")) continue;
    if (!element.checkVisibility()) continue;
    const { color, fontSize, fontWeight, textShadow } = getComputedStyle(element);
    const disabled = element.matches(":disabled, [aria-disabled=true]");
    const judged = /[\\p{L}\\p{N}]{2}/u.test(written);  // axe leaves a lone character undecided
    const look = [background(element), color, fontSize, fontWeight, textShadow, disabled, judged];
    if (!texts.has(look.join())) texts.set(look.join(), element);
  }
  return {violations: (await axe.run({include: [...texts.values()]}, rules)).violations};
}
"""


def defects(page: Page) -> Iterator[str]:
    """Yield a report of what is wrong with a page as it is, with all its parts unfolded."""
    page.evaluate(_UNFOLD)
    page.evaluate(Axe().axe_script)  # once, where `Axe.run` does it each time
    yield from _report(page.evaluate(_RUN, _FOUND))


def defects_in_both_themes(page: Page) -> Iterator[str]:
    """Yield a report for each theme in which something is wrong with a page.

    The themes differ in their colours alone: in the dark one, the contrast of each look is enough.
    """
    page.evaluate(_THEME, "light")
    yield from (f"light: {report}" for report in defects(page))
    page.evaluate(_THEME, "dark")
    contrast = _FOUND | {"runOnly": ["color-contrast"]}
    yield from (f"dark: {report}" for report in _report(page.evaluate(_RUN_ON_LOOKS, contrast)))


def _report(response: dict[str, Any]) -> Iterator[str]:
    found = AxeResults(response)
    if found.violations_count:
        yield found.generate_report()

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
# Judging the contrast of each text takes three quarters of axe's time. One text of each look is
# enough: texts of one look are alike in their own style, in what their ancestors draw behind them
# and in what else is drawn where they are.
_RUN = """
async options => {
  const looks = new Map(), backgrounds = new Map(), painted = [], texts = new Map();
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
  const boxOf = element => {  // numbers: to read them from a DOMRect each time takes longer
    const { left, right, top, bottom } = element.getBoundingClientRect();
    return { left, right, top, bottom };
  };
  const overlap = (a, b) =>
    a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1;
  const all = [...document.body.querySelectorAll("*")].filter(one => one.checkVisibility());
  for (const element of all) {
    const { backgroundColor, backgroundImage, position } = getComputedStyle(element);
    const paints = backgroundColor !== "rgba(0, 0, 0, 0)" || backgroundImage !== "none" ||
      element.matches("img, canvas, svg, video, iframe, input, select, textarea");
    if (paints) painted.push({ element, box: boxOf(element), flows: position === "static" });
  }
  for (const element of all) {
    const written = [...element.childNodes].map(({ nodeType, data }) =>
      nodeType === Node.TEXT_NODE ? data.trim() : "").join("");
    if (!written && !element.matches("input, select, textarea")) continue;
    const { color, fontSize, fontWeight, textShadow } = getComputedStyle(element);
    const disabled = element.matches(":disabled, [aria-disabled=true]");
    const judged = /[\\p{L}\\p{N}]{2}/u.test(written);  // axe leaves a lone character undecided
    const box = boxOf(element);
    const beside = painted.filter(other => overlap(box, other.box) &&
      !other.element.contains(element) && !(other.flows && element.contains(other.element)));
    const behind = new Set(beside.map(other => background(other.element)));
    const look = [background(element), color, fontSize, fontWeight, textShadow, disabled, judged,
      ...[...behind].sort()].join();
    if (!texts.has(look)) texts.set(look, element);
  }
  for (const text of document.querySelectorAll("[data-look]")) delete text.dataset.look;
  for (const text of texts.values()) text.dataset.look = "";
  axe.configure({ rules: [{ id: "color-contrast", selector: "[data-look]" }] });
  return (await axe.run(options)).violations;
}
"""


def defects(page: Page) -> Iterator[str]:
    """Yield a report of what is wrong with a page as it is, with all its parts unfolded."""
    page.evaluate(_UNFOLD)
    page.evaluate(Axe().axe_script)  # once, where `Axe.run` does it each time
    yield from _report(page.evaluate(_RUN, _FOUND))


def faint_texts(page: Page, theme: str) -> Iterator[str]:
    """Yield a report of the texts of a page that are faint in a theme.

    The themes differ in their colours alone, so nothing else is looked at.
    """
    page.evaluate(_UNFOLD)
    page.evaluate(_THEME, theme)
    page.evaluate(Axe().axe_script)
    contrast = _FOUND | {"runOnly": ["color-contrast"]}
    yield from _report(page.evaluate(_RUN, contrast))


def _report(violations: list[dict[str, Any]]) -> Iterator[str]:
    found = AxeResults({"violations": violations})
    if found.violations_count:
        yield found.generate_report()

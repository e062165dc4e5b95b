// The form of a draft: suggests a name, and writes the times of a new one in the zone of its browser.
import { all, need } from "../dom.js";

const form = need(document, "#draft-form", HTMLFormElement);
const title = need(form, "#title", HTMLInputElement);
const name = need(form, "#name", HTMLInputElement);
const zone = need(form, "#zone", HTMLInputElement);

/** @param {string} text as server/pages/competitions/draft_form.py does it */
function suggested(text) {
  const plain = text
    .normalize("NFKD")
    .replace(/[^\x20-\x7e]/g, "")
    .toLowerCase();
  const words = plain.replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "");
  return words && `${/^[a-z]/.test(words) ? words : `cup-${words}`}-v1`;
}

title.addEventListener("input", () => {
  name.placeholder = suggested(title.value) || "harbour-cup-v1";
});

/** @param {Date} at */
function local(at) {
  const shifted = new Date(at.getTime() - 60000 * at.getTimezoneOffset());
  return shifted.toISOString().slice(0, 16);
}

if ("fresh" in form.dataset && zone.value === "UTC") {
  zone.value = Intl.DateTimeFormat().resolvedOptions().timeZone || "UTC";
  for (const field of all(form, '[type="datetime-local"]', HTMLInputElement)) {
    if (zone.value !== "UTC" && field.value) field.value = local(new Date(`${field.value}Z`));
  }
}

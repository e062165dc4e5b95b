// A vehicle of the user's own: checked as soon as its file is chosen, and then the choice of the form.
/**
 * @import { RunForm, VehicleReport } from "../server_data.d.ts"
 * @import { Settings } from "./settings.js"
 */
import { maybe, need } from "../dom.js";
import { element, readJson } from "./check.js";

const URL_CHECK = "/api/v1/vehicles/check";

/**
 * @param {string} title
 * @param {string[]} sentences
 */
function listed(title, sentences) {
  const list = element("ul");
  list.append(...sentences.map((sentence) => element("li", "", sentence)));
  return sentences.length ? [element("p", "", title), list] : [];
}

/** @param {VehicleReport} report */
function reportBox(report) {
  const type = report.errors.length ? "bad" : report.warnings.length ? "warn" : "good";
  const box = element("div", `notice ${type}`);
  const inner = element("div");
  const verdict = report.errors.length ? "This vehicle cannot run:" : `${report.title} can run.`;
  inner.append(element("p", "check-verdict", verdict), ...listed("", report.errors).slice(1));
  inner.append(...listed("Look at these again:", report.warnings));
  if (report.figures.length) {
    const details = element("details");
    const figures = element("pre", "", report.figures.join("\n"));
    figures.tabIndex = 0;
    details.append(element("summary", "", "What it can do"), figures);
    inner.append(details);
  }
  box.append(inner);
  return box;
}

/**
 * @param {RunForm} form
 * @param {Settings} settings
 */
export function startVehicle(form, settings) {
  const part = maybe(form, "[data-own-vehicle]", HTMLElement);
  if (!part) return;
  const input = need(part, "input[type=file]", HTMLInputElement);
  const container = need(part, "[data-vehicle-report]", HTMLElement);
  const select = need(form, "select#vehicle", HTMLSelectElement);
  let offered = ""; // the name of the vehicle in the file, once it is checked

  // A file that is sent has precedence: forget it when another vehicle is chosen.
  function forgetUnlessChosen() {
    if (!offered || select.value === offered) return;
    offered = "";
    input.value = "";
    container.replaceChildren();
  }

  /** @param {string} name */
  function choose(name) {
    select.value = name;
    select.dispatchEvent(new Event("change", { bubbles: true }));
  }

  /** @param {VehicleReport} report */
  function offer(report) {
    const known = [...select.options].some((option) => option.value === report.name);
    if (!known) select.add(new Option(`${report.title} (${report.name})`, report.name));
    if (settings.presets.vehicle) settings.presets.vehicle[report.name] = report.defaults;
    offered = report.name;
    choose(report.name);
  }

  /** @param {File} file */
  async function check(file) {
    container.replaceChildren(element("p", "small muted", "Checking the vehicle."));
    const body = new FormData();
    body.set("vehicle", file);
    const headers = { "X-CSRFToken": form.elements.csrf_token.value, Accept: "application/json" };
    try {
      /** @type {VehicleReport} */
      const report = await readJson(await fetch(URL_CHECK, { method: "POST", body, headers }));
      if (input.files?.[0] !== file) return; // another one by now
      container.replaceChildren(reportBox(report));
      if (!report.errors.length) offer(report);
    } catch (error) {
      if (input.files?.[0] !== file) return;
      const box = element("div", "notice bad");
      box.append(element("p", "", (error instanceof Error && error.message) || "The check failed."));
      container.replaceChildren(box);
    }
  }

  form.addEventListener("change", (event) => {
    if (event.target !== input) return forgetUnlessChosen();
    const before = offered;
    offered = ""; // or else the choice would forget the new file
    if (before) choose(select.dataset.default ?? "");
    container.replaceChildren();
    const file = input.files?.[0];
    if (file) check(file);
  });
  form.addEventListener("click", forgetUnlessChosen); // presets and the reset
}

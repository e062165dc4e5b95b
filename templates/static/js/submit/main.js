// The form of a new run. It works without this script, which adds presets, the editor, the check, drag
// and drop, hiding what a ranked run does not use, and downloading the configuration.
/** @import { RunForm } from "../server_data.d.ts" */
import { all, isNamed, maybe, need } from "../dom.js";
import { programFile, startCheck } from "./check.js";
import { startDraft } from "./draft.js";
import { startEditor } from "./editor.js";
import { startParameters } from "./parameters.js";
import { Settings } from "./settings.js";
import { startSweep, sweepRuns } from "./sweep.js";
import { startUpload } from "./upload.js";
import { startVehicle } from "./vehicle.js";

const SENDING_MS = 4000; // for which a second click on the button is ignored

const form = /** @type {RunForm} */ (need(document, "form#run-form", HTMLFormElement));
const settings = new Settings(form);

const isEntry = "entry" in form.dataset;

/** @param {boolean} ranked */
const kind = (ranked) => (isEntry ? "entry" : ranked ? "ranked" : "practice");

/**
 * What the button says.
 * @param {boolean} ranked
 */
function label(ranked) {
  if (isEntry) return "Submit entry";
  if (ranked) return "Start ranked run";
  const runs = sweepRuns(form);
  return runs > 1 ? `Start ${runs} runs` : "Start run";
}

function showKind() {
  const { ranked } = settings;
  for (const field of all(form, "[data-practice]", HTMLElement)) {
    field.hidden = ranked;
    need(field, "input", HTMLInputElement).disabled = ranked;
  }
  const note = maybe(form, "[data-ranked-note]", HTMLElement);
  if (note) {
    note.hidden = !ranked;
    const titles = settings.unused().map((input) => settings.titleOf(input));
    need(note, "[data-ranked-unused]", HTMLElement).textContent =
      titles.length === 0
        ? ""
        : `Your change${titles.length === 1 ? "" : "s"} of ${titles.join(", ")} will not be used.`;
  }
  need(form, "[data-submit-label]", HTMLElement).textContent = label(ranked);
  const solution = form.querySelector("[name=controller]:checked")?.nextElementSibling?.textContent ?? "";
  const parts = [solution, kind(ranked), settings.summary()];
  need(form, "[data-summary]", HTMLElement).textContent = parts.filter(Boolean).join(" · ");
}

// Says in the form of an assignment that nobody has changed the program in the editor yet.
function showStarterNote() {
  const note = maybe(form, "[data-starter-note]", HTMLElement);
  const { controller, source, language, program_text: text } = form.elements;
  if (!note || !text) return;
  const starter = maybe(form, `[data-program-template="${CSS.escape(language.value)}"]`, HTMLTemplateElement);
  note.hidden =
    controller.value !== "upload" ||
    source.value !== "editor" ||
    text.value.trim() !== starter?.content.textContent?.trim();
}

/** @param {string} name */
function download(name) {
  const text = `${JSON.stringify(settings.configuration(), null, 2)}\n`;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type: "application/json" }));
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

form.addEventListener("input", () => {
  settings.update();
  showKind();
  showStarterNote();
});
form.addEventListener("change", (event) => {
  if (isNamed(event.target, ...Object.keys(settings.presets))) settings.applyPresets();
  else settings.update();
  showKind();
  showStarterNote();
});
form.addEventListener("submit", (event) => {
  const button = need(form, "button[type=submit]", HTMLButtonElement);
  if (button.getAttribute("aria-disabled") === "true") event.preventDefault();
  button.setAttribute("aria-disabled", "true");
  setTimeout(() => button.removeAttribute("aria-disabled"), SENDING_MS);
});

for (const button of all(form, "[data-reset], [data-download-config]", HTMLElement)) {
  button.hidden = false;
  button.addEventListener("click", () => {
    if ("reset" in button.dataset) {
      settings.reset();
      showKind();
    } else download(button.dataset.downloadConfig ?? "");
  });
}
const points = maybe(form, "[data-starting-points]", HTMLElement);
if (points) {
  points.addEventListener("click", ({ target }) => {
    const name = target instanceof HTMLElement ? target.dataset.startingPoint : undefined;
    if (!name) return;
    need(points, "[data-preset-note]", HTMLElement).textContent = settings.togglePoint(name);
    showKind();
  });
}
if (startDraft(form)) settings.applyPresets({ keepValues: true });
settings.update();
settings.fold();
showKind();
const editor = startEditor(form);
startCheck(form, settings, editor);
startUpload(form);
startVehicle(form, settings);
startSweep(form);
startParameters(form, form.dataset.benchmark ?? "", programFile);
showKind();
showStarterNote();
document.getElementById("problems")?.focus();

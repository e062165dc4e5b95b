// The form of a new run. It works without this script, which adds presets, the editor, the check, drag
// and drop, hiding what a ranked run does not use, and downloading the configuration.
import { programFile, startCheck } from "./check.js";
import { startDraft } from "./draft.js";
import { startEditor } from "./editor.js";
import { startParameters } from "./parameters.js";
import { Settings } from "./settings.js";
import { startSweep, sweepRuns } from "./sweep.js";
import { startUpload } from "./upload.js";

const SENDING_MS = 4000; // for which a second click on the button is ignored

const form = document.getElementById("run-form");
const settings = new Settings(form);

function showKind() {
  const { ranked } = settings;
  for (const field of form.querySelectorAll("[data-practice]")) {
    field.hidden = ranked;
    field.querySelector("input").disabled = ranked;
  }
  const note = form.querySelector("[data-ranked-note]");
  if (note) {
    note.hidden = !ranked;
    const titles = settings.unused().map((input) => settings.titleOf(input));
    note.querySelector("[data-ranked-unused]").textContent =
      titles.length === 0
        ? ""
        : `Your change${titles.length === 1 ? "" : "s"} of ${titles.join(", ")} will not be used.`;
  }
  const runs = sweepRuns(form);
  form.querySelector("[data-submit-label]").textContent = ranked
    ? "Start ranked run"
    : runs > 1
      ? `Start ${runs} runs`
      : "Start run";
  const solution = form.querySelector("[name=controller]:checked")?.nextElementSibling.textContent ?? "";
  const parts = [solution, ranked ? "ranked" : "practice", settings.summary()];
  form.querySelector("[data-summary]").textContent = parts.filter(Boolean).join(" · ");
}

// Says in the form of an assignment that nobody has changed the program in the editor yet.
function showStarterNote() {
  const note = form.querySelector("[data-starter-note]");
  const { controller, source, language, program_text: text } = form.elements;
  if (!note || !text) return;
  const starter = form.querySelector(`[data-program-template="${CSS.escape(language.value)}"]`);
  note.hidden =
    controller.value !== "upload" ||
    source.value !== "editor" ||
    text.value.trim() !== starter?.content.textContent.trim();
}

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
  if (event.target.name in settings.presets) settings.applyPresets();
  else settings.update();
  showKind();
  showStarterNote();
});
form.addEventListener("submit", (event) => {
  const button = form.querySelector("button[type=submit]");
  if (button.getAttribute("aria-disabled") === "true") event.preventDefault();
  button.setAttribute("aria-disabled", "true");
  setTimeout(() => button.removeAttribute("aria-disabled"), SENDING_MS);
});

for (const button of form.querySelectorAll("[data-reset], [data-download-config]")) {
  button.hidden = false;
  button.addEventListener("click", () => {
    if ("reset" in button.dataset) {
      settings.reset();
      showKind();
    } else download(button.dataset.downloadConfig);
  });
}
const points = form.querySelector("[data-starting-points]");
if (points) {
  points.addEventListener("click", ({ target }) => {
    const name = target.dataset.startingPoint;
    if (!name) return;
    points.querySelector("[data-preset-note]").textContent = settings.togglePoint(name);
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
startSweep(form);
startParameters(form, form.dataset.benchmark, programFile);
showKind();
showStarterNote();
document.getElementById("problems")?.focus();

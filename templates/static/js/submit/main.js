// The submit page. The form works without this script, which adds presets, the editor, drag and drop,
// locking the scenario of ranked runs, and downloading the configuration.
import { programFile, startCheck } from "./check.js";
import { startDraft } from "./draft.js";
import { startEditor } from "./editor.js";
import { parameterValues, startParameters } from "./parameters.js";
import { startUpload } from "./upload.js";

const form = document.getElementById("run-form");
const presets = JSON.parse(document.getElementById("presets").textContent);
const inputs = [...form.querySelectorAll("[data-default]")];
const defaults = JSON.parse(document.getElementById("defaults").textContent);

function textOf(value) {
  return Array.isArray(value) ? value.join(", ") : String(value);
}

function valueOf(input) {
  return input.type === "checkbox" ? String(input.checked) : input.value;
}

function setValue(input, text) {
  if (input.type === "checkbox") input.checked = text === "true";
  else input.value = text;
}

function markChanged(input) {
  const label = document.getElementById(`${input.name}-label`);
  label?.classList.toggle("changed", valueOf(input).trim() !== input.dataset.default);
}

// Unchanged fields follow the presets of other choices, such as the vehicle; changed fields keep
// their values. The values of a restored draft are all kept.
function applyPresets({ keepValues = false } = {}) {
  const preset = {};
  for (const [name, choices] of Object.entries(presets)) {
    Object.assign(preset, choices[valueOf(form.elements[name])] ?? {});
  }
  for (const input of inputs) {
    if (input.name in presets) continue;
    const before = input.dataset.default;
    const unchanged = !keepValues && valueOf(input).trim() === before;
    input.dataset.default = textOf(preset[input.name] ?? defaults[input.name]);
    if (unchanged) setValue(input, input.dataset.default);
    markChanged(input);
  }
  showApplicable();
}

// Hides settings that have no effect with the other choices, unless they have an error.
function showApplicable() {
  for (const field of form.querySelectorAll("[data-applies]")) {
    const applies = Object.entries(JSON.parse(field.dataset.applies))
      .every(([name, values]) => values.includes(valueOf(form.elements[name])));
    field.hidden = !applies && !field.querySelector(".error");
    field.querySelector("[data-only]").hidden = applies;
  }
  for (const section of form.querySelectorAll("details.advanced, fieldset.group")) {
    const count = section.querySelectorAll("[data-field]:not([hidden])").length;
    section.hidden = count === 0;
    if (section.tagName === "DETAILS") section.querySelector("[data-count]").textContent = count;
  }
}

function lockScenario() {
  const ranked = form.elements.kind.value === "ranked";
  for (const group of form.querySelectorAll('[data-role="scenario"]')) {
    group.disabled = ranked;
    group.querySelector("[data-lock]").hidden = !ranked;
  }
  const practice = form.querySelector("[data-practice]");
  practice.hidden = ranked;
  form.querySelector("[data-submit-label]").textContent = ranked ? "Start ranked run" : "Start run";
}

function configuration() {
  const values = {};
  for (const input of inputs) {
    const text = valueOf(input).trim();
    if (input.type === "checkbox") values[input.name] = input.checked;
    else if (input.dataset.list !== undefined) {
      values[input.name] = text.split(/[\s,;]+/).filter(Boolean).map(Number);
    } else if (input.inputMode === "decimal" && text !== "" && Number.isFinite(Number(text))) {
      values[input.name] = Number(text);
    } else values[input.name] = text;
  }
  return { ...values, ...parameterValues(form) };
}

function download(name) {
  const blob = new Blob([JSON.stringify(configuration(), null, 2) + "\n"], { type: "application/json" });
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  URL.revokeObjectURL(link.href);
}

function resetAll() {
  for (const input of inputs) {
    if (!(input.name in presets)) setValue(input, input.dataset.default);
    markChanged(input);
  }
  showApplicable();
}

form.addEventListener("input", (event) => {
  if (event.target.dataset.default !== undefined) markChanged(event.target);
});
form.addEventListener("change", (event) => {
  if (event.target.name in presets) applyPresets();
  else if (event.target.dataset.default !== undefined || event.target.name === "controller") showApplicable();
  if (event.target.name === "kind") lockScenario();
});
form.addEventListener("submit", () => {
  const button = form.querySelector("button[type=submit]");
  button.setAttribute("aria-disabled", "true");
  setTimeout(() => button.removeAttribute("aria-disabled"), 4000);
});

for (const button of form.querySelectorAll("[data-reset], [data-download-config]")) {
  button.hidden = false;
  button.addEventListener("click", () => {
    if ("reset" in button.dataset) resetAll();
    else download(button.dataset.downloadConfig);
  });
}
if (startDraft(form)) applyPresets({ keepValues: true });
for (const input of inputs) markChanged(input);
showApplicable();
lockScenario();
startEditor(form);
startCheck(form, configuration);
startUpload(form);
startParameters(form, form.dataset.benchmark, programFile);
document.getElementById("problems")?.focus();

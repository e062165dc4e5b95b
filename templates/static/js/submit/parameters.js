// Parameters of one's own program: read from the chosen file or the editor, shown as fields. The server
// reads the declarations (nothing is run); values that were typed stay where the name is the same.
/** @import { Parameter, RunForm } from "../server_data.d.ts" */
import { all, isNamed, need } from "../dom.js";

const URL_READ = "/api/v1/checks?run=false&wait=0";
const PAUSE_MS = 1200; // after the last change in the editor
const PREFIX = "parameters.";
const TEXT_MAX_BYTES = 2 * 1024 * 1024; // as a source file may have

/**
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string>} [attributes]
 * @param {...(string | Node)} children
 * @returns {HTMLElementTagNameMap[K]}
 */
function element(tag, attributes = {}, ...children) {
  const created = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) created.setAttribute(name, value);
  created.append(...children);
  return created;
}

/** @param {Parameter} parameter */
function rangeOf({ low, high }) {
  if (low === null && high === null) return "";
  if (low === null) return `Range: up to ${high}.`;
  return high === null ? `Range: from ${low}.` : `Range: ${low} to ${high}.`;
}

/** @param {Parameter} parameter */
function helpOf(parameter) {
  const description = parameter.description ? `${parameter.description.replace(/\.$/, "")}.` : "";
  const shown = parameter.type === "boolean" ? (parameter.default ? "yes" : "no") : parameter.default;
  return [description, rangeOf(parameter), `Default: ${shown}.`].filter(Boolean).join(" ");
}

/**
 * @param {Parameter} parameter
 * @param {string} id
 * @param {string} value
 */
function inputOf(parameter, id, value) {
  const described = { id, name: id, "aria-describedby": `${id}-help` };
  if (parameter.type !== "boolean") {
    return element("input", {
      ...described,
      type: "text",
      inputmode: "decimal",
      value,
      autocomplete: "off",
      spellcheck: "false",
    });
  }
  const select = element(
    "select",
    described,
    element("option", { value: "true" }, "yes"),
    element("option", { value: "false" }, "no"),
  );
  select.value = value;
  return select;
}

/**
 * @param {Parameter} parameter
 * @param {string} value
 */
function fieldOf(parameter, value) {
  const id = PREFIX + parameter.name;
  const label = element("label", { for: id, id: `${id}-label` }, parameter.name);
  if (parameter.unit) label.append(" ", element("span", { class: "unit" }, `[${parameter.unit}]`));
  return element(
    "div",
    { class: "field", "data-parameter": parameter.name },
    label,
    inputOf(parameter, id, value),
    element("p", { class: "help", id: `${id}-help` }, helpOf(parameter)),
  );
}

/** @typedef {HTMLInputElement | HTMLSelectElement} Control */

/**
 * @param {ParentNode} root
 * @param {string} selector
 * @returns {Control[]}
 */
function controls(root, selector) {
  const kinds = [HTMLInputElement, HTMLSelectElement];
  return all(root, selector, HTMLElement).flatMap((one) =>
    kinds.some((kind) => one instanceof kind) ? [/** @type {Control} */ (one)] : [],
  );
}

/**
 * Returns name -> text of the parameters in the form, as an entry of the configuration.
 * @param {RunForm} form
 */
export function parameterValues(form) {
  /** @type {Record<string, string>} */
  const values = {};
  for (const input of controls(form, `[name^="${PREFIX}"]`)) {
    if (input.value.trim() !== "") values[input.name.slice(PREFIX.length)] = input.value.trim();
  }
  return form.elements.controller.value === "upload" && Object.keys(values).length ? { parameters: values } : {};
}

/**
 * packed: endings of files that are no texts, declaring: words, both separated by spaces. A text without one of
 * the words declares nothing; what a binary or an archive declares, only the server can say.
 * @param {File} program
 * @param {DOMStringMap} data of the form
 */
async function declaresNothing(program, { packed = "", declaring = "" }) {
  const name = program.name.toLowerCase();
  if (program.size >= TEXT_MAX_BYTES || packed.split(" ").some((ending) => name.endsWith(ending))) return false;
  const text = await program.text();
  return !declaring.split(" ").some((word) => text.includes(word));
}

/**
 * benchmark: name; programFile(form): the chosen file, or the editor's text as a file
 * @param {RunForm} form
 * @param {string} benchmark
 * @param {(form: RunForm) => File | undefined} programFile
 */
export function startParameters(form, benchmark, programFile) {
  if (!form.querySelector("[data-own-parameters]") || !form.querySelector("#own-program")) return;
  const box = need(form, "[data-own-parameters]", HTMLElement);
  const fields = need(box, "[data-fields]", HTMLElement);
  const card = box.closest("[data-own-program]");
  let wanted = 0;
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let pause;

  function showCard() {
    box.hidden = fields.childElementCount === 0;
    if (card instanceof HTMLElement) card.hidden = box.hidden || form.elements.controller.value !== "upload";
    form.dispatchEvent(new CustomEvent("parameters"));
  }

  /** @param {Parameter[]} parameters */
  function show(parameters) {
    const typed = new Map(controls(fields, "[name]").map((input) => [input.name, input]));
    /** @type {(name: string) => string | null} */
    const changed = (name) => {
      const input = typed.get(PREFIX + name);
      return input?.dataset.touched ? input.value : null;
    };
    fields.replaceChildren(...parameters.map((one) => fieldOf(one, changed(one.name) ?? String(one.default))));
    for (const input of controls(fields, "[name]")) {
      if (typed.get(input.name)?.dataset.touched) input.dataset.touched = "yes";
    }
    showCard();
  }

  async function read() {
    const sequence = ++wanted;
    const program = programFile(form);
    if (!program) return;
    if (await declaresNothing(program, box.dataset)) {
      if (sequence === wanted) show([]);
      return;
    }
    const body = new FormData();
    body.set("run", JSON.stringify({ benchmark }));
    body.set("program", program);
    const headers = { "X-CSRFToken": form.elements.csrf_token.value, Accept: "application/json" };
    const response = await fetch(URL_READ, { method: "POST", body, headers });
    if (!response.ok || sequence !== wanted) return; // the check and the start say what is wrong
    const answer = await response.json();
    if (sequence === wanted) show(answer.parameters);
  }

  // What the run has that this form begins with counts as typed.
  for (const input of controls(fields, "[name]")) input.dataset.touched = "yes";
  fields.addEventListener("input", (event) => {
    if (event.target instanceof HTMLElement) event.target.dataset.touched = "yes";
  });
  form.addEventListener("change", (event) => {
    if (isNamed(event.target, "controller")) showCard();
    if (isNamed(event.target, "program", "language")) read();
    else if (isNamed(event.target, "source") && programFile(form)) read();
  });
  form.elements.program_text?.addEventListener("input", () => {
    clearTimeout(pause);
    pause = setTimeout(read, PAUSE_MS);
  });
  if (form.elements.source?.value === "editor" && form.elements.controller.value === "upload") read();
  showCard();
}

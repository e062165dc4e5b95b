// The sweep in the form: how many runs it has, and the program's parameters among what can be swept.
/** @import { RunForm } from "../server_data.d.ts" */
import { all, isNamed, maybe, need } from "../dom.js";

/** @param {string} text */
function countOf(text) {
  const range = text.split(":");
  if (range.length === 3) return Number.parseInt(range[2], 10) || 0;
  return text.split(",").filter((part) => part.trim()).length;
}

/** @param {RunForm} form */
function rowsOf(form) {
  return [0, 1].map((index) => ({
    name: maybe(form, `[name="sweep-${index}-name"]`, HTMLSelectElement),
    values: maybe(form, `[name="sweep-${index}-values"]`, HTMLInputElement),
  }));
}

/**
 * Returns how many runs the form starts as a sweep, 0 if it is none.
 * @param {RunForm} form
 */
export function sweepRuns(form) {
  const used = rowsOf(form).filter(({ name, values }) => name?.value && !name.disabled && values?.value.trim());
  return used.length ? used.reduce((product, { values }) => product * countOf(values?.value ?? ""), 1) : 0;
}

/**
 * Offers the parameters of a program first, in a select of what can be swept; keeps what is chosen if it can.
 * @param {HTMLSelectElement} select
 * @param {string[]} names
 */
function offerParameters(select, names) {
  const chosen = select.value;
  for (const option of all(select, "[data-own]", HTMLOptionElement)) option.remove();
  for (const parameter of names.toReversed()) {
    for (const option of select.options) if (option.value === parameter) option.remove();
    const option = new Option(`${parameter} (parameter)`, parameter);
    option.dataset.own = "";
    select.options.add(option, 1);
  }
  select.value = chosen;
  if (select.selectedIndex < 0) select.value = "";
}

/** @param {RunForm} form */
export function startSweep(form) {
  const box = maybe(form, "[data-sweep]", HTMLDetailsElement);
  if (!box) return;
  const most = Number(box.dataset.sweep);
  const note = need(box, "[data-sweep-count]", HTMLElement);
  const card = box.closest(".card");
  const rows = rowsOf(form);

  function showCount() {
    const count = sweepRuns(form);
    const text = count > most ? `This sweep has ${count} runs, which are too many.` : `This sweep has ${count} runs.`;
    note.textContent = count ? text : "";
  }

  function showParameters() {
    const names = all(form, "[data-parameter]", HTMLElement).map((field) => field.dataset.parameter ?? "");
    for (const { name } of rows) if (name) offerParameters(name, names);
    showCount();
  }

  function showKind() {
    const ranked = form.elements.kind.value === "ranked";
    if (card instanceof HTMLElement) card.hidden = ranked;
    for (const control of rows.flatMap(({ name, values }) => [name, values])) if (control) control.disabled = ranked;
  }

  box.addEventListener("input", showCount);
  form.addEventListener("parameters", showParameters);
  form.addEventListener("change", (event) => {
    if (isNamed(event.target, "kind")) showKind();
  });
  if (location.hash === "#sweep") box.open = true;
  showParameters();
  showKind();
}

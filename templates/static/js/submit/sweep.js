// The sweep in the form: how many runs it has, and the program's parameters among what can be swept.

function countOf(text) {
  const range = text.split(":");
  if (range.length === 3) return Number.parseInt(range[2], 10) || 0;
  return text.split(",").filter((part) => part.trim()).length;
}

function rowsOf(form) {
  return [0, 1].map((index) => ({
    name: form.elements[`sweep-${index}-name`],
    values: form.elements[`sweep-${index}-values`],
  }));
}

// Returns how many runs the form starts as a sweep, 0 if it is none.
export function sweepRuns(form) {
  const used = rowsOf(form).filter(({ name, values }) => name && !name.disabled && name.value && values.value.trim());
  return used.length ? used.reduce((product, { values }) => product * countOf(values.value), 1) : 0;
}

// Offers the parameters of a program first, in a select of what can be swept; keeps what is chosen if it can.
function offerParameters(select, names) {
  const chosen = select.value;
  for (const option of select.querySelectorAll("[data-own]")) option.remove();
  for (const parameter of names.toReversed()) {
    for (const option of select.options) if (option.value === parameter) option.remove();
    const option = new Option(`${parameter} (parameter)`, parameter);
    option.dataset.own = "";
    select.options.add(option, 1);
  }
  select.value = chosen;
  if (select.selectedIndex < 0) select.value = "";
}

export function startSweep(form) {
  const box = form.querySelector("[data-sweep]");
  if (!box) return;
  const rows = rowsOf(form);

  function showCount() {
    const count = sweepRuns(form);
    const text =
      count > Number(box.dataset.sweep)
        ? `This sweep has ${count} runs, which are too many.`
        : `This sweep has ${count} runs.`;
    box.querySelector("[data-sweep-count]").textContent = count ? text : "";
  }

  function showParameters() {
    const names = [...form.querySelectorAll("[data-parameter]")].map((field) => field.dataset.parameter);
    for (const { name } of rows) {
      offerParameters(name, names);
    }
    showCount();
  }

  function showKind() {
    const card = box.closest(".card");
    card.hidden = form.elements.kind.value === "ranked";
    for (const { name, values } of rows) name.disabled = values.disabled = card.hidden;
  }

  box.addEventListener("input", showCount);
  form.addEventListener("parameters", showParameters);
  form.addEventListener("change", (event) => {
    if (event.target.name === "kind") showKind();
  });
  if (location.hash === "#sweep") box.open = true;
  showParameters();
  showKind();
}

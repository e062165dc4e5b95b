// A question in a dialog of the page. Escape, and a click beside it, mean no.

/**
 * question: a sentence or two; yes: the label of the button that goes on; danger: what it does cannot be undone
 * @param {string} question
 * @param {{yes?: string, danger?: boolean}} [options]
 * @returns {Promise<boolean>}
 */
export function ask(question, { yes = "OK", danger = false } = {}) {
  const dialog = document.createElement("dialog");
  const text = document.createElement("p");
  const form = document.createElement("form");
  dialog.className = "dialog";
  dialog.setAttribute("aria-labelledby", "dialog-question");
  text.id = "dialog-question";
  text.textContent = question;
  form.method = "dialog";
  form.className = "button-row";
  // The first button has the focus: pressing Enter by mistake changes nothing.
  form.append(button("Go back", "", ""), button(yes, "yes", danger ? "danger" : "primary"));
  dialog.append(text, form);
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  document.body.append(dialog);
  return new Promise((resolve) => {
    dialog.addEventListener("close", () => {
      dialog.remove();
      resolve(dialog.returnValue === "yes");
    });
    dialog.showModal();
  });
}

/**
 * @param {string} label
 * @param {string} value
 * @param {string} kind
 */
function button(label, value, kind) {
  const made = document.createElement("button");
  made.className = `button ${kind}`.trim();
  made.value = value;
  made.textContent = label;
  return made;
}

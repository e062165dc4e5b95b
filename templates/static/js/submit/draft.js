// Keeps the contents of the form when the user visits another page, signs in, or submits an expired
// form. The draft is stored for this tab and deleted once a run has been started.

/** @typedef {HTMLInputElement | HTMLSelectElement | HTMLTextAreaElement} Saved */
/** @typedef {[string, string, boolean | null]} Entry name, value, and whether it is checked if it can be */
/** @typedef {{entries: Entry[], sent: boolean}} Draft */

/**
 * @param {Element} input
 * @returns {input is Saved}
 */
function isSaved(input) {
  const kinds = [HTMLInputElement, HTMLSelectElement, HTMLTextAreaElement];
  const control = kinds.some((kind) => input instanceof kind) ? /** @type {Saved} */ (input) : null;
  return Boolean(control?.name) && control?.type !== "file" && control?.type !== "hidden";
}

/**
 * @param {Saved} input
 * @returns {input is HTMLInputElement}
 */
function isCheckable(input) {
  return input.type === "checkbox" || input.type === "radio";
}

/**
 * @param {string} key
 * @returns {Draft | null}
 */
function read(key) {
  try {
    return JSON.parse(sessionStorage.getItem(key) ?? "null");
  } catch {
    return null; // storage is not available, or holds the format of an older version
  }
}

/**
 * @param {string} key
 * @param {Draft | null} draft
 */
function write(key, draft) {
  try {
    if (draft) sessionStorage.setItem(key, JSON.stringify(draft));
    else sessionStorage.removeItem(key);
  } catch {
    // Without storage there are no drafts.
  }
}

/**
 * @param {HTMLFormElement} form
 * @returns {Entry[]}
 */
function entriesOf(form) {
  const inputs = [...form.elements].filter(isSaved);
  return inputs.map((input) => [input.name, input.value, isCheckable(input) ? input.checked : null]);
}

/**
 * @param {HTMLSelectElement} select
 * @param {string} value
 */
function hasOption(select, value) {
  return [...select.options].some((option) => option.value === value);
}

/**
 * @param {HTMLFormElement} form
 * @param {Entry[]} entries
 */
function restoreEntries(form, entries) {
  const inputs = [...form.elements].filter(isSaved);
  for (const [name, value, checked] of entries) {
    if (checked === null) {
      const input = inputs.find((one) => one.name === name);
      const isGone = input instanceof HTMLSelectElement && !hasOption(input, value); // a vehicle's file
      if (input && !isGone) input.value = value;
    } else {
      const input = inputs
        .filter(isCheckable)
        .find((one) => one.name === name && (one.type === "checkbox" || one.value === value));
      if (input && !input.disabled) input.checked = checked;
    }
  }
}

/**
 * @param {HTMLFormElement} form
 * @param {string} key
 */
function showNotice(form, key) {
  const notice = document.createElement("div");
  notice.className = "notice";
  notice.setAttribute("role", "status");
  const sentence = document.createElement("p");
  const files = form.querySelector("input[type=file]") ? "Files have to be chosen again. " : "";
  sentence.textContent = `Your previous input has been restored. ${files}`;
  const discard = document.createElement("button");
  discard.type = "button";
  discard.className = "button small";
  discard.textContent = "Discard";
  discard.addEventListener("click", () => {
    write(key, null);
    form.dataset.draft = "off";
    location.reload();
  });
  notice.append(sentence, discard);
  form.before(notice);
}

/**
 * Restores an earlier draft unless the server has filled in the form; returns whether it did.
 * @param {HTMLFormElement} form
 */
export function startDraft(form) {
  const key = `draft ${location.pathname}`;
  const draft = read(key);
  const initial = JSON.stringify(entriesOf(form));
  const filledByServer = document.getElementById("problems") || location.search;
  const returned = document.referrer && new URL(document.referrer).pathname === location.pathname;
  const restore = Boolean(draft && !filledByServer && (!draft.sent || returned));
  write(key, null);
  if (restore && draft) {
    restoreEntries(form, draft.entries);
    showNotice(form, key);
  }
  let sent = false;
  form.addEventListener("submit", () => {
    sent = true;
  });
  addEventListener("pagehide", () => {
    const entries = entriesOf(form);
    const changed = JSON.stringify(entries) !== initial;
    if (changed && form.dataset.draft !== "off") write(key, { entries, sent });
  });
  return restore;
}

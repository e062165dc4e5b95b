// Keeps the contents of the form when the user visits another page, signs in, or submits an expired
// form. The draft is stored for this tab and deleted once a run has been started.

function isSaved(input) {
  return input.name && input.type !== "file" && input.type !== "hidden" && !input.matches("button");
}

function isCheckable(input) {
  return input.type === "checkbox" || input.type === "radio";
}

function read(key) {
  try {
    return JSON.parse(sessionStorage.getItem(key));
  } catch {
    return null; // storage is not available, or holds the format of an older version
  }
}

function write(key, draft) {
  try {
    if (draft) sessionStorage.setItem(key, JSON.stringify(draft));
    else sessionStorage.removeItem(key);
  } catch {
    // Without storage there are no drafts.
  }
}

function entriesOf(form) {
  const inputs = [...form.elements].filter(isSaved);
  return inputs.map((input) => [input.name, input.value, isCheckable(input) ? input.checked : null]);
}

function restoreEntries(form, entries) {
  const inputs = [...form.elements].filter(isSaved);
  for (const [name, value, checked] of entries) {
    if (checked === null) {
      const input = inputs.find((one) => one.name === name);
      if (input) input.value = value;
    } else {
      const input = inputs.find((one) => one.name === name && (one.type === "checkbox" || one.value === value));
      if (input && !input.disabled) input.checked = checked;
    }
  }
}

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

// Restores an earlier draft unless the server has filled in the form; returns whether it did.
export function startDraft(form) {
  const key = `draft ${location.pathname}`;
  const draft = read(key);
  const initial = JSON.stringify(entriesOf(form));
  const filledByServer = document.getElementById("problems") || location.search;
  const returned = document.referrer && new URL(document.referrer).pathname === location.pathname;
  const restore = Boolean(draft && !filledByServer && (!draft.sent || returned));
  write(key, null);
  if (restore) {
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

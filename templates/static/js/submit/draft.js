// What somebody typed into the form survives a look at another page, signing in, and a form that
// was refused as out of date. It stays in this tab and is forgotten once a run has been started.

function usable(input) {
  return input.name && input.type !== "file" && input.type !== "hidden" && !input.matches("button");
}

function picked(input) {
  return input.type === "checkbox" || input.type === "radio";
}

function read(key) {
  try {
    return JSON.parse(sessionStorage.getItem(key));
  } catch {
    return null; // storage may be forbidden, or hold what an older version wrote
  }
}

function write(key, draft) {
  try {
    if (draft) sessionStorage.setItem(key, JSON.stringify(draft));
    else sessionStorage.removeItem(key);
  } catch {
    // Then the form is as forgetful as without this file.
  }
}

function state(form) {
  const inputs = [...form.elements].filter(usable);
  return inputs.map((input) => [input.name, input.value, picked(input) ? input.checked : null]);
}

function put(form, entries) {
  const inputs = [...form.elements].filter(usable);
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

function tell(form, key) {
  const notice = document.createElement("div");
  notice.className = "notice";
  notice.setAttribute("role", "status");
  const sentence = document.createElement("p");
  sentence.textContent = "What you had entered is here again; a file has to be chosen again. ";
  const afresh = document.createElement("button");
  afresh.type = "button";
  afresh.className = "button small";
  afresh.textContent = "Start afresh";
  afresh.addEventListener("click", () => {
    write(key, null);
    form.dataset.draft = "off";
    location.reload();
  });
  notice.append(sentence, afresh);
  form.before(notice);
}

// Puts an earlier draft back, unless the server has filled in the form; true if it did.
export function startDraft(form) {
  const key = `draft ${location.pathname}`;
  const draft = read(key);
  const begun = JSON.stringify(state(form));
  const filled = document.getElementById("problems") || location.search;
  const cameBack = document.referrer && new URL(document.referrer).pathname === location.pathname;
  const restore = Boolean(draft && !filled && (!draft.sent || cameBack));
  write(key, null);
  if (restore) {
    put(form, draft.entries);
    tell(form, key);
  }
  let sent = false;
  form.addEventListener("submit", () => { sent = true; });
  addEventListener("pagehide", () => {
    const entries = state(form);
    const changed = JSON.stringify(entries) !== begun;
    if (changed && form.dataset.draft !== "off") write(key, { entries, sent });
  });
  return restore;
}

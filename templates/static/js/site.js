// Behaviour of all pages: dark mode, copying links and code, questions before changes.

import { ask } from "./dialog.js";
import { all, around, need } from "./dom.js";

const root = document.documentElement;

function dark() {
  if (root.dataset.theme) return root.dataset.theme === "dark";
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

function switchTheme() {
  root.dataset.theme = dark() ? "light" : "dark";
  try {
    localStorage.setItem("theme", root.dataset.theme);
  } catch {
    // Without storage, the choice applies to this page only.
  }
  document.dispatchEvent(new CustomEvent("themechange"));
}

/** @param {HTMLButtonElement} button */
async function copy(button) {
  const text = button.dataset.copy || location.href;
  try {
    await navigator.clipboard.writeText(new URL(text, location.href).href);
    announce(button, "Copied");
  } catch {
    announce(button, "Copy failed");
  }
}

/** @param {HTMLButtonElement} button */
async function copyCode(button) {
  try {
    await navigator.clipboard.writeText(need(button.parentElement ?? document, "pre", HTMLElement).textContent);
    announce(button, "Copied");
  } catch {
    announce(button, "Copy failed");
  }
}

/**
 * @param {HTMLButtonElement} button
 * @param {string} text
 */
function announce(button, text) {
  const label = button.querySelector("[data-label]") ?? button;
  const before = label.textContent;
  label.textContent = text;
  button.setAttribute("aria-live", "polite");
  setTimeout(() => {
    label.textContent = before;
  }, 1800);
}

document.addEventListener("click", (event) => {
  const button = around(event.target, "button", HTMLButtonElement);
  if (!button) return;
  if ("themeSwitch" in button.dataset) switchTheme();
  if ("copy" in button.dataset) copy(button);
  if ("copyCode" in button.dataset) copyCode(button);
});

// A button named "question" sends its form only after its value has been answered with yes. Without this script
// the server asks (server/web/confirmation.py).
document.addEventListener("submit", async (event) => {
  const { submitter, target: form } = event;
  if (!(submitter instanceof HTMLButtonElement) || submitter.name !== "question") return;
  if (!(form instanceof HTMLFormElement)) return;
  event.preventDefault();
  const yes = submitter.textContent.trim();
  if (!(await ask(submitter.value, { yes, danger: submitter.classList.contains("danger") }))) return;
  submitter.name = "answered";
  form.requestSubmit(submitter);
  submitter.name = "question";
});

/**
 * An open menu closes by Escape, and when somebody goes elsewhere.
 * @param {EventTarget | null} [except]
 */
function closeMenus(except = null) {
  const kept = except instanceof Node ? except : null;
  for (const menu of all(document, "details.menu[open]", HTMLDetailsElement)) {
    if (!menu.contains(kept)) menu.open = false;
  }
}
document.addEventListener("click", ({ target }) => closeMenus(target));
document.addEventListener("focusin", ({ target }) => closeMenus(target));
document.addEventListener("keydown", ({ key, target }) => {
  const menu = key === "Escape" ? around(target, "details.menu[open]", HTMLDetailsElement) : null;
  if (!menu) return;
  menu.open = false;
  need(menu, "summary", HTMLElement).focus();
});

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  document.dispatchEvent(new CustomEvent("themechange"));
});

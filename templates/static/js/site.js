// Behaviour of all pages: dark mode, copying links and code, questions before changes.
import { ask } from "./dialog.js";

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

async function copy(button) {
  const text = button.dataset.copy || location.href;
  try {
    await navigator.clipboard.writeText(new URL(text, location.href).href);
    announce(button, "Copied");
  } catch {
    announce(button, "Copy failed");
  }
}

async function copyCode(button) {
  try {
    await navigator.clipboard.writeText(button.parentElement.querySelector("pre").textContent);
    announce(button, "Copied");
  } catch {
    announce(button, "Copy failed");
  }
}

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
  const button = event.target.closest("button");
  if (!button) return;
  if ("themeSwitch" in button.dataset) switchTheme();
  if ("copy" in button.dataset) copy(button);
  if ("copyCode" in button.dataset) copyCode(button);
});

// A button named "question" sends its form only after its value has been answered with yes. Without this script
// the server asks (server/web/confirmation.py).
document.addEventListener("submit", async (event) => {
  const { submitter, target: form } = event;
  if (submitter?.name !== "question") return;
  event.preventDefault();
  const yes = submitter.textContent.trim();
  if (!(await ask(submitter.value, { yes, danger: submitter.classList.contains("danger") }))) return;
  submitter.name = "answered";
  form.requestSubmit(submitter);
  submitter.name = "question";
});

// An open menu closes by Escape, and when somebody goes elsewhere.
function closeMenus(except = null) {
  for (const menu of document.querySelectorAll("details.menu[open]")) if (!menu.contains(except)) menu.open = false;
}
document.addEventListener("click", ({ target }) => closeMenus(target));
document.addEventListener("focusin", ({ target }) => closeMenus(target));
document.addEventListener("keydown", ({ key, target }) => {
  const menu = key === "Escape" ? target.closest("details.menu[open]") : null;
  if (!menu) return;
  menu.open = false;
  menu.querySelector("summary").focus();
});

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  document.dispatchEvent(new CustomEvent("themechange"));
});

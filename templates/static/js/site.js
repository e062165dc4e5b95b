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
  setTimeout(() => { label.textContent = before; }, 1800);
}

document.addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  if ("themeSwitch" in button.dataset) switchTheme();
  if ("copy" in button.dataset) copy(button);
  if ("copyCode" in button.dataset) copyCode(button);
});

// A button with data-confirm sends its form only after the question has been answered with yes.
document.addEventListener("submit", async (event) => {
  const { submitter, target: form } = event;
  const question = submitter?.dataset.confirm;
  if (!question || submitter.dataset.confirmed === question) return;
  event.preventDefault();
  const yes = submitter.textContent.trim();
  if (!(await ask(question, { yes, danger: submitter.classList.contains("danger") }))) return;
  submitter.dataset.confirmed = question;
  form.requestSubmit(submitter);
  delete submitter.dataset.confirmed;
});

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  document.dispatchEvent(new CustomEvent("themechange"));
});

// What every page has: the menu on a phone, the colour switch, copying of links, questions first.

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
    // Storage may be forbidden; the choice then lasts for this page.
  }
  document.dispatchEvent(new CustomEvent("themechange"));
}

function toggleMenu(button) {
  const open = document.getElementById(button.getAttribute("aria-controls")).classList.toggle("open");
  button.setAttribute("aria-expanded", String(open));
}

async function copy(button) {
  const text = button.dataset.copy || location.href;
  try {
    await navigator.clipboard.writeText(new URL(text, location.href).href);
    announce(button, "Copied");
  } catch {
    announce(button, "Copy the address bar instead");
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
  if ("menu" in button.dataset) toggleMenu(button);
  if ("copy" in button.dataset) copy(button);
});

document.addEventListener("submit", (event) => {
  const question = event.submitter?.dataset.confirm;
  if (question && !confirm(question)) event.preventDefault();
});

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  document.dispatchEvent(new CustomEvent("themechange"));
});

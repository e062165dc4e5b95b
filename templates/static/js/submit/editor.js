// A text area with line numbers, indentation by Tab and automatic indentation of new lines.
import { ask } from "../dialog.js";

const INDENT = "    ";

function replaceSelection(area, text) {
  // execCommand instead of value=... keeps the browser's undo history.
  if (!document.execCommand("insertText", false, text)) {
    area.setRangeText(text, area.selectionStart, area.selectionEnd, "end");
  }
}

function selectWholeLines(area) {
  const start = area.value.lastIndexOf("\n", area.selectionStart - 1) + 1;
  let end = area.selectionEnd;
  if (end > start && area.value[end - 1] === "\n") end -= 1;
  const next = area.value.indexOf("\n", end);
  area.setSelectionRange(start, next < 0 ? area.value.length : next);
}

function indent(area, back) {
  if (area.selectionStart === area.selectionEnd && !back) {
    replaceSelection(area, INDENT);
    return;
  }
  selectWholeLines(area);
  const from = area.selectionStart;
  const lines = area.value.slice(from, area.selectionEnd).split("\n");
  const changed = lines.map((line) => (back ? line.replace(/^ {1,4}|^\t/, "") : line && INDENT + line));
  replaceSelection(area, changed.join("\n"));
  area.setSelectionRange(from, from + changed.join("\n").length);
}

function newLine(area) {
  const start = area.value.lastIndexOf("\n", area.selectionStart - 1) + 1;
  const line = area.value.slice(start, area.selectionStart);
  const spaces = line.match(/^[ \t]*/)[0];
  replaceSelection(area, "\n" + spaces + (line.trimEnd().match(/[:{]$/) ? INDENT : ""));
}

export function startEditor(form) {
  const area = form.querySelector(".editor textarea");
  if (!area) return;
  const gutter = form.querySelector(".editor .lines");
  let leaving = false; // Escape, then Tab leaves the editor, for keyboard users

  function numberLines() {
    const count = area.value.split("\n").length;
    gutter.textContent = Array.from({ length: count }, (_, i) => i + 1).join("\n");
    gutter.scrollTop = area.scrollTop;
  }

  area.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      leaving = true;
      return;
    }
    if (event.key === "Tab" && !leaving && !event.ctrlKey && !event.altKey) {
      event.preventDefault();
      indent(area, event.shiftKey);
    } else if (event.key === "Enter" && !event.isComposing && !event.shiftKey) {
      event.preventDefault();
      newLine(area);
    }
    if (event.key !== "Shift") leaving = false;
  });
  area.addEventListener("input", numberLines);
  area.addEventListener("scroll", () => { gutter.scrollTop = area.scrollTop; });

  const language = form.querySelector("#language");
  const templates = new Map();
  for (const each of form.querySelectorAll("[data-program-template]")) {
    templates.set(each.dataset.programTemplate, each.content.textContent);
  }

  function insertTemplate() {
    area.value = templates.get(language.value);
    numberLines();
  }

  language.addEventListener("change", () => { // keep the user's own text
    if (!area.value.trim() || [...templates.values()].includes(area.value)) insertTemplate();
  });
  const template = form.querySelector("[data-template]");
  template.hidden = false;
  template.addEventListener("click", async () => {
    const text = templates.get(language.value);
    if (area.value.trim() && area.value !== text && !(await ask("Replace the contents of the editor?", { yes: "Replace" }))) return;
    insertTemplate();
    area.focus();
  });
  numberLines();
}

// Switching between file and editor, drag and drop, and the size of the file before it is sent.
/** @import { RunForm } from "../server_data.d.ts" */
import { all, isNamed, need } from "../dom.js";

/** @param {number} bytes */
function mebibytes(bytes) {
  return `${(bytes / 2 ** 20).toFixed(1)} MiB`;
}

/** @param {RunForm} form */
export function startUpload(form) {
  const section = document.getElementById("own-program");
  if (!section) return;
  const input = need(document, "input#program", HTMLInputElement);
  const drop = need(section, ".drop", HTMLElement);
  const check = need(form, "[data-check-bar]", HTMLElement);
  const note = need(section, "[data-file-note]", HTMLElement);
  const maxBytes = Number(form.dataset.uploadMax);

  /** @param {HTMLElement} own what belongs to an own program */
  function show(own) {
    own.hidden = form.elements.controller.value !== "upload";
    check.hidden = own.hidden;
    for (const part of all(own, "[data-source]", HTMLElement)) {
      part.hidden = part.dataset.source !== form.elements.source.value;
    }
    input.disabled = form.elements.source.value !== "file"; // a file that is sent has precedence
  }

  function describe() {
    const file = input.files?.[0];
    note.className = "small muted";
    if (!file) {
      note.textContent = "";
      return;
    }
    const tooLarge = file.size > maxBytes;
    note.textContent = tooLarge
      ? `${file.name} is too large: ${mebibytes(file.size)}. The limit is ${mebibytes(maxBytes)}.`
      : `${file.name}, ${file.size.toLocaleString("en")} bytes`;
    if (tooLarge) note.className = "error-text";
  }

  form.addEventListener("change", (event) => {
    if (isNamed(event.target, "controller", "source")) show(section);
    if (event.target === input) describe();
  });
  drop.addEventListener("dragover", (event) => {
    event.preventDefault();
    drop.classList.add("over");
  });
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    if (!event.dataTransfer?.files.length) return;
    input.files = event.dataTransfer.files;
    describe();
  });
  show(section);
  describe();
}

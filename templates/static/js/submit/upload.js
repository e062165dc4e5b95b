// Switching between file and editor, drag and drop, and the size of the file before it is sent.

function mebibytes(bytes) {
  return `${(bytes / 2 ** 20).toFixed(1)} MiB`;
}

export function startUpload(form) {
  const section = document.getElementById("own-program");
  if (!section) return;
  const input = document.getElementById("program");
  const drop = section.querySelector(".drop");
  const check = form.querySelector("[data-check-bar]");
  const note = section.querySelector("[data-file-note]");
  const maxBytes = Number(form.dataset.uploadMax);

  function show() {
    section.hidden = form.elements.controller.value !== "upload";
    check.hidden = section.hidden;
    for (const part of section.querySelectorAll("[data-source]")) {
      part.hidden = part.dataset.source !== form.elements.source.value;
    }
    input.disabled = form.elements.source.value !== "file"; // a file that is sent has precedence
  }

  function describe() {
    const file = input.files[0];
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
    if (event.target.name === "controller" || event.target.name === "source") show();
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
    if (!event.dataTransfer.files.length) return;
    input.files = event.dataTransfer.files;
    describe();
  });
  show();
  describe();
}

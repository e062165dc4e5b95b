// Choosing between file and editor, dropping a file, and its size said before it is sent.

function megabytes(bytes) {
  return (bytes / 2 ** 20).toFixed(1) + " MiB";
}

export function startUpload(form) {
  const own = document.getElementById("own-program");
  if (!own) return;
  const input = document.getElementById("program");
  const drop = own.querySelector(".drop");
  const check = form.querySelector("[data-check-bar]");
  const note = own.querySelector("[data-file-note]");
  const most = Number(form.dataset.uploadMax);

  function show() {
    own.hidden = form.elements.controller.value !== "upload";
    check.hidden = own.hidden;
    for (const part of own.querySelectorAll("[data-source]")) {
      part.hidden = part.dataset.source !== form.elements.source.value;
    }
  }

  function describe() {
    const file = input.files[0];
    note.className = "small muted";
    if (!file) {
      note.textContent = "";
      return;
    }
    const tooLarge = file.size > most;
    note.textContent = tooLarge
      ? `${file.name} has ${megabytes(file.size)}; the largest program is ${megabytes(most)}.`
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

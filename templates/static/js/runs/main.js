// The list of runs: how many are selected, and which buttons fit that number.

const form = document.querySelector("[data-runs]");
const boxes = [...(form?.querySelectorAll('input[name="runs"]') ?? [])];
const every = form?.querySelector("[data-every]");

function show() {
  const count = boxes.filter((box) => box.checked).length;
  form.querySelector("[data-selected]").textContent = count ? `${count} selected` : "";
  for (const button of form.querySelectorAll('button[type="submit"]')) {
    button.disabled = count < Number(button.dataset.from ?? 1) || count > Number(button.dataset.to ?? Infinity);
  }
  const all = every.querySelector("input");
  all.checked = count === boxes.length;
  all.indeterminate = count > 0 && count < boxes.length;
}

if (form) {
  every.hidden = false;
  every.addEventListener("change", (event) => {
    for (const box of boxes) box.checked = event.target.checked;
    show();
  });
  form.addEventListener("change", show);
  window.addEventListener("pageshow", show); // a browser that goes back restores the boxes
  show();
}

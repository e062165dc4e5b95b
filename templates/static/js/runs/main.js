// The list of runs: how many are selected, and which buttons fit that number.
import { all, maybe, need } from "../dom.js";

/**
 * @param {HTMLFormElement} form
 * @param {HTMLInputElement[]} boxes
 * @param {HTMLInputElement} every
 */
function showCount(form, boxes, every) {
  const count = boxes.filter((box) => box.checked).length;
  need(form, "[data-selected]", HTMLElement).textContent = count ? `${count} selected` : "";
  for (const button of all(form, 'button[type="submit"]', HTMLButtonElement)) {
    button.disabled = count < Number(button.dataset.from ?? 1) || count > Number(button.dataset.to ?? Infinity);
  }
  every.checked = count === boxes.length;
  every.indeterminate = count > 0 && count < boxes.length;
}

const form = maybe(document, "[data-runs]", HTMLFormElement);
if (form) {
  const boxes = all(form, 'input[name="runs"]', HTMLInputElement);
  const label = need(form, "[data-every]", HTMLElement);
  const every = need(label, "input", HTMLInputElement);
  const show = () => showCount(form, boxes, every);
  label.hidden = false;
  every.addEventListener("change", () => {
    for (const box of boxes) box.checked = every.checked;
    show();
  });
  form.addEventListener("change", show);
  window.addEventListener("pageshow", show); // a browser that goes back restores the boxes
  show();
}

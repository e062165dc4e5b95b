// Pages of many runs: while some of them are waiting or running, the parts are replaced by those of a fresh copy.
import { all, around, maybe } from "./dom.js";

const INTERVAL_MS = 2000;

let waiting = false; // a part that has the focus

function chosen() {
  return new Set(all(document, '[name="runs"]:checked', HTMLInputElement).map((box) => box.value));
}

async function refresh() {
  const response = await fetch(location.pathname + location.search, { credentials: "same-origin" });
  if (!response.ok) return;
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  const focused = around(document.activeElement, "[data-part]", HTMLElement)?.dataset.part;
  const kept = chosen();
  waiting = false;
  for (const old of all(document, "[data-part]", HTMLElement)) {
    const next = maybe(fresh, `[data-part="${old.dataset.part}"]`, HTMLElement);
    // A part with the focus waits: replacing it would move somebody who uses the keyboard.
    if (next && old.dataset.part === focused) waiting = true;
    else if (next) old.replaceChildren(...next.childNodes);
  }
  for (const box of all(document, '[name="runs"]', HTMLInputElement)) box.checked = kept.has(box.value);
}

async function follow() {
  if (!waiting && !document.querySelector("[data-live]")) return;
  try {
    if (!document.hidden) await refresh();
  } catch {
    // The next attempt may succeed.
  }
  setTimeout(follow, INTERVAL_MS);
}

setTimeout(follow, INTERVAL_MS);

// Pages of many runs: while some of them are waiting or running, the parts are replaced by those of a fresh copy.

const INTERVAL_MS = 2000;

let waiting = false; // a part that has the focus

function chosen() {
  return new Set([...document.querySelectorAll('[name="runs"]:checked')].map((box) => box.value));
}

async function refresh() {
  const response = await fetch(location.pathname + location.search, { credentials: "same-origin" });
  if (!response.ok) return;
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  const focused = document.activeElement?.closest("[data-part]")?.dataset.part;
  const kept = chosen();
  waiting = false;
  for (const old of document.querySelectorAll("[data-part]")) {
    const next = fresh.querySelector(`[data-part="${old.dataset.part}"]`);
    // A part with the focus waits: replacing it would move somebody who uses the keyboard.
    if (next && old.dataset.part === focused) waiting = true;
    else if (next) old.replaceChildren(...next.childNodes);
  }
  for (const box of document.querySelectorAll('[name="runs"]')) box.checked = kept.has(box.value);
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

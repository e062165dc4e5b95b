// The page of a sweep: while runs are waiting or running, its parts are replaced by those of a fresh copy.

const INTERVAL_MS = 2000;

function chosen() {
  return new Set([...document.querySelectorAll('[name="runs"]:checked')].map((box) => box.value));
}

async function refresh() {
  const response = await fetch(location.pathname, { credentials: "same-origin" });
  if (!response.ok) return;
  const fresh = new DOMParser().parseFromString(await response.text(), "text/html");
  const focused = document.activeElement?.closest("[data-part]")?.dataset.part;
  const kept = chosen();
  for (const old of document.querySelectorAll("[data-part]")) {
    const next = fresh.querySelector(`[data-part="${old.dataset.part}"]`);
    // A part with the focus waits: replacing it would move somebody who uses the keyboard.
    if (next && old.dataset.part !== focused) old.replaceChildren(...next.childNodes);
  }
  for (const box of document.querySelectorAll('[name="runs"]')) box.checked = kept.has(box.value);
}

async function follow() {
  if (!document.querySelector("[data-live]")) return;
  try {
    if (!document.hidden) await refresh();
  } catch {
    // The next attempt may succeed.
  }
  setTimeout(follow, INTERVAL_MS);
}

setTimeout(follow, INTERVAL_MS);

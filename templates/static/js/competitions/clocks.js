// Adds the time on the reader's clock to each time in the zone of a competition, where they differ.
import { all } from "../dom.js";

const SHOWN = /** @type {const} */ ({
  weekday: "short",
  day: "2-digit",
  month: "short",
  hour: "2-digit",
  minute: "2-digit",
});

/**
 * @param {Date} at
 * @param {string} [zone] that of the browser if it is left out
 */
function clock(at, zone) {
  return new Intl.DateTimeFormat("en-GB", { ...SHOWN, hourCycle: "h23", timeZone: zone }).format(at);
}

for (const time of all(document, "time[data-zone]", HTMLTimeElement)) {
  const at = new Date(time.dateTime);
  const own = clock(at);
  if (own === clock(at, time.dataset.zone)) continue;
  const added = document.createElement("small");
  added.className = "muted";
  added.textContent = ` (${own} for you)`;
  time.append(added);
}

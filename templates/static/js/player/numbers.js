// The numbers at the playhead, beside the scene.

const DEGREES = 180 / Math.PI;

function number(value, digits, unit) {
  if (!Number.isFinite(value)) return "–";
  return `${value.toFixed(digits).replace("-", "−")} ${unit}`;
}

// Where the water flows to, as a compass course.
function current({ current_x: north, current_y: east }) {
  if (north == null || east == null) return "–"; // a log without it
  const speed = Math.hypot(north, east);
  if (!Number.isFinite(speed)) return "–";
  if (speed < 0.005) return "none";
  const course = (Math.atan2(east, north) * DEGREES + 360) % 360;
  return `${speed.toFixed(2)} m/s to ${course.toFixed(0)}°`;
}

function tracker({ tracker_ok: ok, tracker_error: error }) {
  if (ok == null) return "–"; // a log without corners
  return ok === 1 ? `error ${number(error, 1, "px")}` : "lost the target";
}

const SHOWN = [
  ["Distance to station", (row) => number(row.distance, 3, "m")],
  ["Target from centre", (row) => number(row.distance_px, 1, "px")],
  ["Tracker", tracker],
  ["Current", current],
  ["Depth", (row) => number(row.z, 2, "m")],
  ["Heading", (row) => number(((row.yaw * DEGREES) % 360 + 360) % 360, 1, "°")],
];

export class Numbers {
  constructor(list) {
    this.values = SHOWN.map(([label, text]) => {
      const pair = document.createElement("div");
      const name = document.createElement("dt");
      const value = document.createElement("dd");
      name.textContent = label;
      pair.append(name, value);
      list.append(pair);
      return { value, text };
    });
  }

  show(row) {
    for (const { value, text } of this.values) {
      const now = row ? text(row) : "–";
      if (value.textContent !== now) value.textContent = now;
    }
  }
}

// How numbers are written beside scene and charts. No page is needed for it.

const DEGREES = 180 / Math.PI;
const STILL_M_S = 0.005; // a current that is slower has no direction worth a number

/**
 * A value of a chart, with three digits.
 * @param {number | null | undefined} value
 */
export function short(value) {
  if (value === null || value === undefined) return "–";
  const text = Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3);
  return text.replace("-", "−");
}

/** @param {number} t simulated time [s] */
export function clockText(t) {
  if (t < 60) return `${t.toFixed(2)} s`;
  const tenths = Math.round(10 * t); // first: 59.95 s are a minute
  const minutes = Math.floor(tenths / 600);
  return `${minutes}:${(tenths / 10 - 60 * minutes).toFixed(1).padStart(4, "0")} min`;
}

/**
 * @param {number | null | undefined} value
 * @param {number} digits after the point
 * @param {string} unit
 */
export function number(value, digits, unit) {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  return `${value.toFixed(digits).replace("-", "−")} ${unit}`;
}

/** @param {number | null | undefined} yaw [rad] */
export function heading(yaw) {
  return number(typeof yaw === "number" ? (((yaw * DEGREES) % 360) + 360) % 360 : null, 1, "°");
}

/**
 * Where the water flows to, as a compass course.
 * @param {number | null | undefined} north [m/s]
 * @param {number | null | undefined} east [m/s]
 */
export function current(north, east) {
  const speed = Math.hypot(north ?? Number.NaN, east ?? Number.NaN);
  if (!Number.isFinite(speed)) return "–";
  if (speed < STILL_M_S) return "none";
  const course = (Math.atan2(Number(east), Number(north)) * DEGREES + 360) % 360;
  return `${speed.toFixed(2)} m/s to ${course.toFixed(0)}°`;
}

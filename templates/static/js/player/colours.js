// Colours of the theme for canvases.

export const LINES = ["--chart-1", "--chart-2", "--chart-3", "--good", "--bad", "--warn"];

/** @type {Map<string, string>} */
const known = new Map(); // asking the page costs a style calculation each time
document.addEventListener("themechange", () => known.clear());

/**
 * @param {string} name
 * @returns {string}
 */
export function colour(name) {
  const value = known.get(name) ?? computed(name);
  known.set(name, value);
  return value;
}

/**
 * Custom properties may contain light-dark(...), which is only resolved in a computed colour.
 * @param {string} name
 */
function computed(name) {
  const probe = document.createElement("i");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

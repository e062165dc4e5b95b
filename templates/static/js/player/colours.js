// Colours of the theme for canvases.

export const LINES = ["--chart-1", "--chart-2", "--chart-3", "--good", "--bad", "--warn"];

const known = new Map(); // asking the page costs a style calculation each time
document.addEventListener("themechange", () => known.clear());

export function colour(name) {
  if (!known.has(name)) known.set(name, computed(name));
  return known.get(name);
}

// Custom properties may contain light-dark(...), which is only resolved in a computed colour.
function computed(name) {
  const probe = document.createElement("i");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

// Colours of the theme for canvases.

export const LINES = ["--chart-1", "--chart-2", "--chart-3", "--good", "--bad", "--warn"];

// Custom properties may contain light-dark(...), which is only resolved in a computed colour.
export function colour(name) {
  const probe = document.createElement("i");
  probe.style.color = `var(${name})`;
  document.body.append(probe);
  const value = getComputedStyle(probe).color;
  probe.remove();
  return value;
}

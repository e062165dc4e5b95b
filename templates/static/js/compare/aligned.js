// Lines with different points on one axis, as a chart wants them. No page is needed for it.

/**
 * [x, values of each line]; null where a line has no point.
 * @param {{x: number[], values: number[]}[]} lines
 * @returns {[number[], ...(number | null)[][]]}
 */
export function aligned(lines) {
  const x = [...new Set(lines.flatMap((line) => line.x))].sort((a, b) => a - b);
  const known = lines.map((line) => new Map(line.x.map((at, index) => [at, line.values[index]])));
  return [x, ...known.map((points) => x.map((at) => points.get(at) ?? null))];
}

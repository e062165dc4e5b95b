// Lines of levels from easy to hard: their colours go from one to another. No page is needed for it.

/**
 * A colour between two that are written as `rgb(r, g, b)`.
 * @param {string[]} ends
 * @param {number} share of the way
 */
export function mixed([from, to], share) {
  const [first, last] = [from, to].map((text) => (text.match(/[\d.]+/g) ?? []).slice(0, 3).map(Number));
  return `rgb(${first.map((value, index) => Math.round(value + share * (last[index] - value))).join(", ")})`;
}

/** @param {number[]} shares */
export function meanPercent(shares) {
  return shares.length ? (100 * shares.reduce((sum, share) => sum + share, 0)) / shares.length : Number.NaN;
}

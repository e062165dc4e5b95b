// Text that changes with every picture costs a drawing of the page each time, and nobody can read it.

const PERIOD_MS = 100;

/**
 * Returns a function that calls `write` at once, then at most once in a period; the last call counts.
 * @param {() => void} write
 * @param {number} [period]
 */
export function paced(write, period = PERIOD_MS) {
  /** @type {ReturnType<typeof setTimeout> | undefined} */
  let timer;
  let written = -Infinity;
  const now = () => {
    timer = undefined;
    written = performance.now();
    write();
  };
  return () => {
    if (timer !== undefined) return;
    const wait = written + period - performance.now();
    if (wait <= 0) now();
    else timer = setTimeout(now, wait);
  };
}

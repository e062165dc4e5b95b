// What a reload resumes: in the session storage of the tab, and the moment also in the address.

const WRITE_MS = 400;

export class Memory {
  /** @param {string} key */
  constructor(key) {
    this.key = key;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.timer = undefined;
    /** @type {Record<string, any>} what other code has stored: each user of a name knows its type */
    this.values = {};
    try {
      this.values = JSON.parse(sessionStorage.getItem(key) ?? "{}") ?? {};
    } catch {
      // Without storage nothing is resumed.
    }
    /** @type {PerformanceEntry & {type?: string} | undefined} */
    const navigation = performance.getEntriesByType("navigation")[0];
    const reloaded = navigation?.type === "reload";
    const linked = new URLSearchParams(location.hash.slice(1));
    if (linked.has("t") && !reloaded) {
      this.values.playhead = { t: Number(linked.get("t")), trial: Number(linked.get("trial") ?? 0), following: false };
    }
    addEventListener("pagehide", () => this.write());
  }

  /**
   * @template T
   * @param {string} name
   * @param {T} fallback
   * @returns {T}
   */
  get(name, fallback) {
    return this.values[name] ?? fallback;
  }

  /**
   * @param {string} name
   * @param {unknown} value
   */
  set(name, value) {
    this.values[name] = value;
    this.timer ??= setTimeout(() => this.write(), WRITE_MS);
  }

  write() {
    clearTimeout(this.timer);
    this.timer = undefined;
    try {
      sessionStorage.setItem(this.key, JSON.stringify(this.values));
    } catch {
      // As above.
    }
    const { playhead } = this.values;
    if (!playhead || playhead.playing || playhead.following || playhead.t === 0) return;
    const trial = playhead.trial ? `&trial=${playhead.trial}` : "";
    history.replaceState(history.state, "", `#t=${Number(playhead.t.toFixed(2))}${trial}`);
  }
}

// The layout of the player's page, the same for all runs: how wide the scene is beside the camera, and what
// is folded. It is kept in the browser's storage.
import { all, need } from "../dom.js";

const KEY = "player-layout";
const SHARE = { least: 25, most: 75, usual: 63, step: 2 }; // of the scene [%]

/** @typedef {{share?: number, folds?: Record<string, boolean>}} Kept */

export class Layout {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.root = root;
    this.views = need(root, "[data-views]", HTMLElement);
    this.splitter = need(root, "[data-splitter]", HTMLElement);
    this.kept = read();
    this.share = SHARE.usual;
    this.setShare(this.kept.share ?? SHARE.usual);
    this.splitter.hidden = false;
    this.splitter.addEventListener("keydown", (event) => this.onKey(event));
    this.splitter.addEventListener("pointerdown", (event) => this.drag(event));
    this.splitter.addEventListener("dblclick", () => this.keepShare(SHARE.usual));
    this.unfold();
    // A "toggle" event does not bubble; parts of the page that the server renders anew are not listened to one by one.
    root.addEventListener(
      "toggle",
      ({ target }) => {
        if (!(target instanceof HTMLDetailsElement) || !target.dataset.fold) return;
        this.keep({ folds: { ...this.kept.folds, [target.dataset.fold]: target.open } });
      },
      true,
    );
  }

  // Folds and unfolds as it was; also what the server has rendered anew.
  unfold() {
    for (const part of all(this.root, "details[data-fold]", HTMLDetailsElement)) {
      part.open = this.kept.folds?.[part.dataset.fold ?? ""] ?? part.open;
    }
  }

  /** @param {number} share */
  setShare(share) {
    this.share = Math.round(Math.min(Math.max(share, SHARE.least), SHARE.most));
    this.views.style.setProperty("--scene-share", `${this.share}fr`);
    this.views.style.setProperty("--camera-share", `${100 - this.share}fr`);
    this.splitter.setAttribute("aria-valuenow", String(this.share));
    this.splitter.setAttribute("aria-valuetext", `${this.share} % scene, ${100 - this.share} % camera`);
  }

  /** @param {number} share */
  keepShare(share) {
    this.setShare(share);
    this.keep({ share: this.share });
  }

  /** @param {KeyboardEvent} event */
  onKey(event) {
    /** @type {Record<string, number>} */
    const shares = {
      ArrowLeft: this.share - SHARE.step,
      ArrowRight: this.share + SHARE.step,
      Home: SHARE.least,
      End: SHARE.most,
      Enter: SHARE.usual,
    };
    const to = shares[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation(); // the player would go to another time
    this.keepShare(to);
  }

  /** @param {PointerEvent} event */
  drag(event) {
    event.preventDefault();
    this.splitter.focus();
    this.splitter.setPointerCapture(event.pointerId);
    const { left, width } = this.views.getBoundingClientRect();
    /** @type {(event: PointerEvent) => void} */
    const move = ({ clientX }) => this.setShare(((clientX - left) / width) * 100);
    this.splitter.addEventListener("pointermove", move);
    this.splitter.addEventListener(
      "lostpointercapture",
      () => {
        this.splitter.removeEventListener("pointermove", move);
        this.keepShare(this.share);
      },
      { once: true },
    );
  }

  /** @param {Kept} values */
  keep(values) {
    Object.assign(this.kept, values);
    try {
      localStorage.setItem(KEY, JSON.stringify(this.kept));
    } catch {
      // Without storage, the layout is that of this page only.
    }
  }
}

/** @returns {Kept} */
function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY) ?? "{}") ?? {};
  } catch {
    return {};
  }
}

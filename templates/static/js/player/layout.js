// The layout of the player's page, the same for all runs: how wide the scene is beside the camera, and what
// is folded. It is kept in the browser's storage.

const KEY = "player-layout";
const SHARE = { least: 25, most: 75, usual: 63, step: 2 }; // of the scene [%]

export class Layout {
  constructor(root) {
    this.root = root;
    this.views = root.querySelector("[data-views]");
    this.splitter = root.querySelector("[data-splitter]");
    this.kept = read();
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
        if (target.dataset?.fold) this.keep({ folds: { ...this.kept.folds, [target.dataset.fold]: target.open } });
      },
      true,
    );
  }

  // Folds and unfolds as it was; also what the server has rendered anew.
  unfold() {
    for (const part of this.root.querySelectorAll("details[data-fold]")) {
      part.open = this.kept.folds?.[part.dataset.fold] ?? part.open;
    }
  }

  setShare(share) {
    this.share = Math.round(Math.min(Math.max(share, SHARE.least), SHARE.most));
    this.views.style.setProperty("--scene-share", `${this.share}fr`);
    this.views.style.setProperty("--camera-share", `${100 - this.share}fr`);
    this.splitter.setAttribute("aria-valuenow", String(this.share));
    this.splitter.setAttribute("aria-valuetext", `${this.share} % scene, ${100 - this.share} % camera`);
  }

  keepShare(share) {
    this.setShare(share);
    this.keep({ share: this.share });
  }

  onKey(event) {
    const to = {
      ArrowLeft: this.share - SHARE.step,
      ArrowRight: this.share + SHARE.step,
      Home: SHARE.least,
      End: SHARE.most,
      Enter: SHARE.usual,
    }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    event.stopPropagation(); // the player would go to another time
    this.keepShare(to);
  }

  drag(event) {
    event.preventDefault();
    this.splitter.focus();
    this.splitter.setPointerCapture(event.pointerId);
    const { left, width } = this.views.getBoundingClientRect();
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

  keep(values) {
    Object.assign(this.kept, values);
    try {
      localStorage.setItem(KEY, JSON.stringify(this.kept));
    } catch {
      // Without storage, the layout is that of this page only.
    }
  }
}

function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}

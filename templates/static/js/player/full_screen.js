// The player alone on the whole screen: a button and the bar's key "f" enter and leave it, Escape leaves.

export class FullScreen {
  constructor(root) {
    this.root = root;
    this.button = root.querySelector("[data-full-screen]");
    if (!document.fullscreenEnabled) return; // the button stays hidden
    this.button.hidden = false;
    this.button.addEventListener("click", () => this.toggle());
    document.addEventListener("fullscreenchange", () => this.show());
  }

  toggle() {
    if (!document.fullscreenEnabled) return;
    if (document.fullscreenElement) document.exitFullscreen();
    else this.root.requestFullscreen();
  }

  show() {
    const whole = document.fullscreenElement === this.root;
    this.button.querySelector("[data-label]").textContent = whole ? "Leave full screen" : "Full screen";
  }
}

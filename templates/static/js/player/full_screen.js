// The player alone on the whole screen: a button and the bar's key "f" enter and leave it, Escape leaves.
import { need } from "../dom.js";

export class FullScreen {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.root = root;
    this.button = need(root, "[data-full-screen]", HTMLButtonElement);
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
    need(this.button, "[data-label]", HTMLElement).textContent = whole ? "Leave full screen" : "Full screen";
  }
}

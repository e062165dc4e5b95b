// The menu of the player's bar and its keys: picture, clip, list of shortcuts, views.
import { Capture } from "./capture.js";

export class Menu {
  constructor(bar, player, { name, tell }) {
    this.root = bar.querySelector("[data-menu]");
    this.dialog = bar.querySelector("[data-shortcuts]");
    this.stopButton = bar.querySelector("[data-stop-clip]");
    this.capture = new Capture(player, { name, tell, onRecording: (seconds) => this.showRecording(seconds) });
    const actions = {
      picture: () => this.capture.picture(),
      clip: () => this.capture.toggle(),
      shortcuts: () => this.dialog.showModal(),
    };
    this.keys = { p: actions.picture, r: actions.clip, "?": actions.shortcuts };
    for (const button of this.root.querySelectorAll("[data-action]")) {
      button.addEventListener("click", () => {
        this.root.open = false;
        actions[button.dataset.action]();
      });
    }
    this.stopButton.addEventListener("click", () => this.capture.stop());
    this.dialog.addEventListener("click", ({ target }) => {
      if (target === this.dialog) this.dialog.close();
    });
    document.addEventListener("click", ({ target }) => {
      if (!this.root.contains(target)) this.root.open = false;
    });
    this.root.addEventListener("keydown", ({ key }) => {
      if (key !== "Escape" || !this.root.open) return;
      this.root.open = false;
      this.root.querySelector("summary").focus();
    });
  }

  // seconds: of the clip so far, null without one
  showRecording(seconds) {
    const records = seconds !== null;
    this.stopButton.hidden = !records;
    if (!records) return;
    const text = `Stop recording, ${Math.floor(seconds)} s`;
    if (this.stopButton.textContent !== text) this.stopButton.textContent = text;
  }
}

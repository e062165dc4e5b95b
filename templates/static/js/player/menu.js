// The menu of the player's bar and its keys: picture, clip, list of shortcuts, views.
/** @import { Player } from "./player.js" */
import { all, need } from "../dom.js";
import { Capture } from "./capture.js";

export class Menu {
  /**
   * @param {HTMLElement} bar
   * @param {Player} player
   * @param {{name: string, tell: (sentence: string) => void}} options
   */
  constructor(bar, player, { name, tell }) {
    this.root = need(bar, "[data-menu]", HTMLDetailsElement);
    this.dialog = need(bar, "[data-shortcuts]", HTMLDialogElement);
    this.stopButton = need(bar, "[data-stop-clip]", HTMLButtonElement);
    this.capture = new Capture(player, { name, tell, onRecording: (seconds) => this.showRecording(seconds) });
    /** @type {Record<string, () => void>} */
    const actions = {
      picture: () => this.capture.picture(),
      clip: () => this.capture.toggle(),
      shortcuts: () => this.dialog.showModal(),
    };
    this.keys = { p: actions.picture, r: actions.clip, "?": actions.shortcuts };
    for (const button of all(this.root, "[data-action]", HTMLElement)) {
      button.addEventListener("click", () => {
        this.root.open = false;
        actions[button.dataset.action ?? ""]?.();
      });
    }
    this.stopButton.addEventListener("click", () => this.capture.stop());
    this.dialog.addEventListener("click", ({ target }) => {
      if (target === this.dialog) this.dialog.close();
    });
    document.addEventListener("click", ({ target }) => {
      if (!(target instanceof Node && this.root.contains(target))) this.root.open = false;
    });
    this.root.addEventListener("keydown", ({ key }) => {
      if (key !== "Escape" || !this.root.open) return;
      this.root.open = false;
      need(this.root, "summary", HTMLElement).focus();
    });
  }

  /**
   * seconds: of the clip so far, null without one
   * @param {number | null} seconds
   */
  showRecording(seconds) {
    this.stopButton.hidden = seconds === null;
    if (seconds === null) return;
    const text = `Stop recording, ${Math.floor(seconds)} s`;
    if (this.stopButton.textContent !== text) this.stopButton.textContent = text;
  }
}

// What a detector recognised, on the page of its run: asked for once, when the part comes into sight.
/**
 * @import { Example, PlayerData, Recognition, SceneData } from "../server_data.d.ts"
 * @import { Player } from "../player/player.js"
 */
import { maybe, need } from "../dom.js";
import { showConfusion, showTimes } from "./confusion.js";
import { showGallery } from "./gallery.js";
import { PrecisionRecall } from "./precision_recall.js";

const EARLY_PX = 400; // before it is in sight

export class RecognitionPart {
  /**
   * @param {HTMLElement} box
   * @param {PlayerData} data
   * @param {Player} player
   */
  constructor(box, data, player) {
    this.box = box;
    this.data = data;
    this.player = player;
    this.note = need(box, "[data-recognition-note]", HTMLElement);
    this.asked = false;
    new IntersectionObserver(
      (entries) => {
        if (entries[entries.length - 1].isIntersecting) this.load();
      },
      { rootMargin: `${EARLY_PX}px` },
    ).observe(box);
  }

  async load() {
    if (this.asked || this.data.live) return;
    this.asked = true;
    this.note.textContent = "Loading…";
    const [answer, scene] = await Promise.all([
      fetch(`${this.data.api}/recognition.json`),
      fetch(`${this.data.api}/scene.json?trial=0&level=0`),
    ]);
    if (!answer.ok || !scene.ok) {
      this.note.textContent = "Curves and examples could not be loaded. Reload the page to try again.";
      return;
    }
    this.show(await answer.json(), await scene.json());
  }

  /**
   * @param {Recognition} found
   * @param {SceneData} scene
   */
  show(found, scene) {
    const { box, data } = this;
    if (!found.levels.length) {
      this.note.textContent = "There is nothing to show: the run recorded no whole level.";
      return;
    }
    const shown = need(box, "[data-recognised]", HTMLElement);
    shown.hidden = false;
    this.note.hidden = true;
    const { label } = data.level;
    new PrecisionRecall(need(box, "[data-precision]", HTMLElement), found, label);
    showConfusion(need(box, "[data-confusion]", HTMLElement), found);
    showTimes(need(box, "[data-times]", HTMLElement), found, label);
    showGallery(need(box, "[data-examples]", HTMLElement), found.examples, {
      page: location.pathname,
      api: data.api,
      image: scene.camera,
      depth: (level) => `${label.toLowerCase()} ${data.levels[level]}`,
      go: (example) => this.go(example),
    });
    need(box, "[data-read]", HTMLElement).textContent =
      found.images < found.recorded ? `From the first ${found.images} of ${found.recorded} images.` : "";
  }

  /** @param {Example} example */
  async go({ trial, t }) {
    maybe(this.player.root, "[data-views]", HTMLElement)?.scrollIntoView({ block: "start" });
    await this.player.setTrial(trial);
    this.player.playhead.seek(t);
  }
}

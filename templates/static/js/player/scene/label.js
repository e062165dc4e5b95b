// A few words beside a point of the scene, such as the newtons at an arrow.
/** @import { Camera, Vector3 } from "three" */

export class Label {
  /**
   * @param {HTMLElement} box
   * @param {string} name
   */
  constructor(box, name) {
    this.box = box;
    this.element = document.createElement("p");
    this.element.className = "scene-label";
    this.element.dataset.label = name;
    this.element.hidden = true;
    box.append(this.element);
  }

  hide() {
    if (!this.element.hidden) this.element.hidden = true;
  }

  /**
   * place: in the frame of the screen, y up
   * @param {Camera} camera
   * @param {Vector3} place
   * @param {string} text
   */
  show(camera, place, text) {
    const { x, y, z } = place.clone().project(camera);
    if (z > 1 || Math.abs(x) > 1 || Math.abs(y) > 1) {
      this.hide();
      return;
    }
    const { clientWidth: width, clientHeight: height } = this.box;
    const [left, top] = [((x + 1) / 2) * width, ((1 - y) / 2) * height].map((pixels) => `${pixels.toFixed(0)}px`);
    this.element.style.transform = `translate(${left}, ${top}) translate(0.4rem, -50%)`;
    if (this.element.textContent !== text) this.element.textContent = text;
    this.element.hidden = false;
  }
}

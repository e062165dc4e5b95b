// An arrow at the edge of the scene, towards something that is out of sight.
/** @import { Camera } from "three" */
import { Vector3 } from "../../../vendor/three/three.min.js";

const MARGIN_PX = 30;

export class Pointer {
  /**
   * name: of the thing, in words
   * @param {HTMLElement} box
   * @param {string} name
   */
  constructor(box, name) {
    this.box = box;
    this.name = name;
    this.element = document.createElement("p");
    this.element.className = "scene-pointer";
    this.element.dataset.pointer = name;
    this.element.hidden = true;
    this.arrow = document.createElement("i");
    this.arrow.textContent = "→";
    this.text = document.createElement("span");
    this.element.append(this.arrow, this.text);
    box.append(this.element);
  }

  hide() {
    if (!this.element.hidden) this.element.hidden = true;
  }

  /**
   * place: in the frame of the screen, y up; distance: in words, empty if unknown
   * @param {Camera} camera
   * @param {Vector3} place
   * @param {string} distance
   */
  show(camera, place, distance) {
    const seen = place.clone().applyMatrix4(camera.matrixWorldInverse);
    const { x, y } = place.clone().project(camera);
    if (seen.z < 0 && Math.abs(x) < 1 && Math.abs(y) < 1) {
      this.hide();
      return;
    }
    const { clientWidth: width, clientHeight: height } = this.box;
    const direction = new Vector3(seen.x, -seen.y, 0);
    if (direction.length() < 1e-6) direction.set(0, 1, 0);
    const [across, down] = [width / 2 - 2 * MARGIN_PX, height / 2 - MARGIN_PX];
    const reach = Math.min(across / Math.abs(direction.x), down / Math.abs(direction.y));
    direction.multiplyScalar(reach);
    const [left, top] = [width / 2 + direction.x, height / 2 + direction.y].map((pixels) => `${pixels.toFixed(0)}px`);
    this.element.style.transform = `translate(${left}, ${top}) translate(-50%, -50%)`;
    this.arrow.style.transform = `rotate(${Math.atan2(direction.y, direction.x).toFixed(2)}rad)`;
    const text = distance ? `${this.name} ${distance}` : this.name;
    if (this.text.textContent !== text) this.text.textContent = text;
    this.element.hidden = false;
  }
}

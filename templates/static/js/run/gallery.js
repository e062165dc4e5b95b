// The pictures of a detector's run that teach most: each shows a part of an image, and leads to it in the player.
/** @import { Example, Optics, Recognition } from "../server_data.d.ts" */
import { crop } from "./crop.js";

/** @type {[keyof Recognition["examples"], string, string][]} */
export const KINDS = [
  ["false_alarms", "Most confident false alarms", "There was no false alarm."],
  ["misses", "Missed in the clearest water", "No object was missed."],
  ["hits", "Least confident hits", "There was no hit."],
];

/**
 * @param {Example} example
 * @param {string} depth
 */
export function caption({ label, confidence, lies_on: on }, depth) {
  const sure = confidence === null ? "" : ` ${confidence.toFixed(2)}`;
  const where = on === null ? "" : ` on ${on.toLowerCase()}`;
  return `${label}${sure}${where}, ${depth}`;
}

/**
 * @param {HTMLElement} box
 * @param {Recognition["examples"]} examples
 * @param {{page: string, api: string, depth: (level: number) => string, image: Optics,
 *   go: (example: Example) => void}} run
 */
export function showGallery(box, examples, run) {
  box.replaceChildren(
    ...KINDS.flatMap(([kind, title, none]) => {
      const head = document.createElement("h3");
      head.textContent = title;
      const list = document.createElement("ul");
      list.className = "gallery";
      list.append(...examples[kind].map((example) => item(example, run)));
      const nothing = document.createElement("p");
      nothing.className = "muted";
      nothing.textContent = none;
      return [head, examples[kind].length ? list : nothing];
    }),
  );
}

/**
 * @param {Example} example
 * @param {Parameters<typeof showGallery>[2]} run
 */
function item(example, run) {
  const { trial, t } = example;
  const text = caption(example, run.depth(example.level));
  const link = document.createElement("a");
  link.href = `${run.page}#t=${t}&trial=${trial}`;
  link.addEventListener("click", (event) => {
    if (event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    run.go(example);
  });
  const frame = document.createElement("span");
  frame.className = "crop";
  const image = document.createElement("img");
  image.loading = "lazy";
  image.alt = "";
  image.src = `${run.api}/camera.jpg?trial=${trial}&t=${t.toFixed(2)}`;
  const { left, top, side } = crop(example.corners, run.image);
  Object.assign(image.style, {
    width: `${100 / side}%`,
    left: `${(-100 * left) / side}%`,
    top: `${(-100 * top) / side}%`,
  });
  frame.append(image);
  link.append(frame, text);
  const made = document.createElement("li");
  made.append(link);
  return made;
}

// What moves before the player draws must be on the screen before the player takes the processor.
import { maybe } from "../dom.js";

/**
 * Resolves as soon as the picture of a stage has been painted, or cannot be.
 * @param {ParentNode} root
 */
export async function posterShown(root) {
  const poster = maybe(root, ".poster", HTMLImageElement);
  if (!poster) return;
  await poster.decode().catch(() => {});
  await new Promise((/** @type {(value?: unknown) => void} */ done) => {
    requestAnimationFrame(() => setTimeout(done));
  });
}

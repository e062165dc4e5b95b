// Which part of an image shows an object: a rectangle of the image's own shape, as a picture of it.

const AROUND = 2.4; // side of the part, in sides of what is outlined
const LEAST = 0.35; // of the image: the surroundings tell what something was taken for

/**
 * Left, top and side of the part, as shares of the image.
 * @param {[number, number][]} corners [px]
 * @param {{width: number, height: number}} image [px]
 * @returns {{left: number, top: number, side: number}}
 */
export function crop(corners, { width, height }) {
  /** @type {(along: 0 | 1, size: number) => {middle: number, extent: number}} */
  const span = (along, size) => {
    const values = corners.map((corner) => Math.min(Math.max(corner[along] / size, 0), 1));
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return { middle: (low + high) / 2, extent: high - low };
  };
  const [across, down] = [span(0, width), span(1, height)];
  const side = Math.min(Math.max(AROUND * Math.max(across.extent, down.extent), LEAST), 1);
  /** @type {(middle: number) => number} */
  const start = (middle) => Math.min(Math.max(middle - side / 2, 0), 1 - side);
  return { left: start(across.middle), top: start(down.middle), side };
}

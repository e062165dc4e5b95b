// One picture of the moment that is shown: scene, camera, numbers and time on a canvas, to be saved or recorded.

const FONT = "system-ui, sans-serif";
const COLOURS = { page: "#0b1a22", text: "#f1f7f9", muted: "#9db4bf", line: "#2d4856", done: "#4fc3d6" };
// Shares of the canvas: width of the scene, height of what is above the footer.
const SCENE = 0.68;
const BODY = 0.9;
const GAP = 0.012; // of the height

/**
 * What a picture shows.
 * @typedef {object} Picture
 * @property {HTMLCanvasElement | null} scene
 * @property {HTMLImageElement | null} camera
 * @property {[string, string][]} numbers label and text
 * @property {string} clock
 * @property {string} title
 * @property {number} share of the trial
 */

/** @typedef {[number, number, number, number]} Box left, top, width, height */

/**
 * Draws an image so that it fills the box, cut at its longer sides.
 * @param {CanvasRenderingContext2D} context
 * @param {CanvasImageSource} image
 * @param {number} width
 * @param {number} height
 * @param {Box} box
 */
function fill(context, image, width, height, [x, y, w, h]) {
  if (!width || !height) return;
  const scale = Math.max(w / width, h / height);
  const [sw, sh] = [w / scale, h / scale];
  context.drawImage(image, (width - sw) / 2, (height - sh) / 2, sw, sh, x, y, w, h);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Picture} moment
 */
export function compose(context, moment) {
  const { width, height } = context.canvas;
  const gap = GAP * height;
  const body = BODY * height;
  const middle = moment.scene ? SCENE * width : 0;
  context.fillStyle = COLOURS.page;
  context.fillRect(0, 0, width, height);
  if (moment.scene) fill(context, moment.scene, moment.scene.width, moment.scene.height, [0, 0, middle, body]);
  const left = middle + (middle ? gap : 0);
  const column = moment.scene ? width - left : SCENE * width;
  let below = 0;
  if (moment.camera) {
    const { naturalWidth: w, naturalHeight: h } = moment.camera;
    below = Math.min((column * h) / w, body * (moment.scene ? 0.55 : 1));
    fill(context, moment.camera, w, h, [left, 0, column, below]);
  }
  if (moment.scene) writeNumbers(context, moment.numbers, [left, below + 2 * gap, column, body - below]);
  else writeNumbers(context, moment.numbers, [column + 2 * gap, 2 * gap, width - column, body]);
  writeFooter(context, moment, [0, body, width, height - body]);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {string} text
 * @param {number} x
 * @param {number} y
 * @param {{size: number, weight?: number, colour?: string, align?: CanvasTextAlign}} style
 */
function write(context, text, x, y, { size, weight = 400, colour = COLOURS.text, align = "left" }) {
  context.font = `${weight} ${size}px ${FONT}`;
  context.fillStyle = colour;
  context.textAlign = align;
  context.textBaseline = "alphabetic";
  context.fillText(text, x, y);
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {[string, string][]} numbers
 * @param {Box} box
 */
function writeNumbers(context, numbers, [x, y, , height]) {
  const row = Math.min(height / numbers.length, 0.062 * context.canvas.height);
  numbers.forEach(([label, text], index) => {
    const top = y + index * row;
    write(context, label, x + row * 0.3, top + row * 0.36, { size: row * 0.32, colour: COLOURS.muted });
    write(context, text, x + row * 0.3, top + row * 0.8, { size: row * 0.42, weight: 600 });
  });
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Picture} moment
 * @param {Box} box
 */
function writeFooter(context, { clock, title, share }, [x, y, width, height]) {
  const inset = height * 0.3;
  context.fillStyle = COLOURS.line;
  context.fillRect(x, y, width, height * 0.06);
  context.fillStyle = COLOURS.done;
  context.fillRect(x, y, width * share, height * 0.06);
  write(context, clock, x + inset, y + height * 0.66, { size: height * 0.36, weight: 600 });
  write(context, title, x + width - inset, y + height * 0.66, {
    size: height * 0.3,
    colour: COLOURS.muted,
    align: "right",
  });
}

// The looping replay of a run on the home page and on leaderboards. three.js is loaded when it comes into sight.
/** @import { PlayerData } from "../server_data.d.ts" */
/** @import { Memory } from "../player/memory.js" */
import { dataOf, need } from "../dom.js";
import { clockText } from "../player/formatting.js";
import { Playhead } from "../player/playhead.js";
import { Rows, rowColumns } from "../player/rows.js";
import { SceneBox } from "../player/scene_box.js";
import { posterShown } from "./poster.js";

const SPEED = 5;
/** @type {Pick<Memory, "get" | "set">} */
const FORGETFUL = { get: (_name, fallback) => fallback, set: () => {} };

/** @type {PlayerData} */
const data = dataOf("run-data");
const root = need(document, "[data-scene]", HTMLElement);
await posterShown(root);
const button = need(root, "[data-play]", HTMLButtonElement);
const clock = need(root, "[data-clock]", HTMLElement);
const playhead = new Playhead({ duration: data.trial_s, loop: true });
const rows = new Rows(data.api, rowColumns(data.columns));
const scene = new SceneBox(root, data, FORGETFUL);
let seen = false;
let asked = false; // to play or to pause
let frame = 0; // that is asked for
/** @type {number | null} */
let before = null;

function show() {
  need(button, "[data-label]", HTMLElement).textContent = playhead.playing ? "Pause" : "Play";
  rows.want(playhead);
  const instant = rows.at(0, playhead.t);
  if (!instant) return;
  clock.textContent = clockText(playhead.t);
  scene.show(playhead, instant, () => rows.before(0, playhead.t, 20 * SPEED));
}

/** @param {number} now */
function tick(now) {
  playhead.advance(Math.min((now - (before ?? now)) / 1000, 0.25));
  before = now;
  frame = 0;
  run();
}

// Asks for a frame only while it plays in sight.
function run() {
  if (frame) return;
  if (seen && playhead.playing) frame = requestAnimationFrame(tick);
  else before = null;
}

function begin() {
  playhead.reaches(data.trial_s);
  playhead.moveTo(Number(root.dataset.start ?? 0));
  playhead.setSpeed(SPEED);
  playhead.listen((_playhead, what) => {
    show();
    if (what === "mode") run();
  });
  rows.onRows = show;
  button.hidden = false;
  button.addEventListener("click", () => {
    asked = true;
    playhead.toggle();
  });
  show();
  playUnasked();
}

// Not where the processor draws: what nobody has asked for would keep more than a core busy.
async function playUnasked() {
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
  await scene.loaded;
  if (!scene.software && !asked) playhead.play();
}

new IntersectionObserver((entries) => {
  seen = entries[entries.length - 1].isIntersecting;
  if (seen && !playhead.newest) begin();
  else run();
}).observe(root);

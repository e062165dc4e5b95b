// The demo: the player of a run on the recorded one, which plays by itself.
/** @import { PlayerData } from "../server_data.d.ts" */
import { dataOf, need } from "../dom.js";
import { Player } from "../player/player.js";
import { posterShown } from "./poster.js";

const SPEED = 2;

/** @type {PlayerData} */
const data = dataOf("run-data");
const root = need(document, "[data-player]", HTMLElement);
await posterShown(root);
const player = new Player(root, data);
const { playhead } = player;

await player.start();
if (playhead.t === 0) {
  playhead.setSpeed(SPEED);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) playhead.play();
}

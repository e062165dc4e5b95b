// The demo: the player of a run on the recorded one, which plays by itself.
import { Player } from "../player/player.js";
import { posterShown } from "./poster.js";

const SPEED = 2;

const data = JSON.parse(document.getElementById("run-data").textContent);
const root = document.querySelector("[data-player]");
await posterShown(root);
const player = new Player(root, data);
const { playhead } = player;

await player.start();
if (playhead.t === 0) {
  playhead.setSpeed(SPEED);
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) playhead.play();
}

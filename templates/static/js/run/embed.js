// The player of a run in a frame of another page.
import { Player } from "../player/player.js";
import { followRows } from "./live.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
const player = new Player(document.querySelector("[data-player]"), data);

await player.start();
if (data.live) followRows(player, data);
